//! The check of UAV-INF against the UAVs that UAV-LIST lists.
//!
//! UAVs come and go. So UAV-INF lacks one only if the lists before and after it have that UAV, and no OBJ-DEL in between
//! names it. If the request has the id twice, that may be the cause, and the other rule reports it.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{
    Detail, Exchange, Location, PerConnection, RuleContext, Session, SessionCheck, body, reply, served,
    uav_inf_07,
};

/// Puts records between two lists of the same UAVs.
pub(super) fn listed_twice(session: &mut Session, say: impl FnOnce(&mut Session)) {
    let list = || -> (Value, Value) { (json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] })) };
    let (request, answer) = list();
    session.exchange(request, answer);
    say(session);
    let (request, answer) = list();
    session.exchange(request, answer);
}

/// How many UAVs that aren't known are kept of a connection.
const MAX_DOUBTED: usize = 1_000;

/// UAVs that UAV-INF doesn't know, connection by connection.
#[derive(Default)]
pub(super) struct Unknown {
    /// True if it looks at trials with an id twice in the request, false if it looks at all other requests.
    is_of_repeated: bool,
    connections: PerConnection<Listed>,
}

/// The UAVs that were listed on a connection.
#[derive(Default)]
struct Listed {
    /// The latest list.
    uavs: BTreeSet<String>,
    /// Those of it that UAV-INF hasn't known since, and where it says so.
    doubted: Vec<(String, Location)>,
}

impl SessionCheck for Unknown {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if self.is_of_repeated {
            served::served(exchange, context);
        }
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        if exchange.response("UAV-INF").is_some() {
            return self.inform(exchange, context);
        }
        let list = reply::listed(exchange);
        let listed = self.connections.get(exchange);
        if exchange.notification("OBJ-DEL").is_some() {
            let is_left = |id: &String| list.as_ref().is_some_and(|gone| !gone.contains(id));
            listed.uavs.retain(is_left);
            listed.doubted.retain(|(id, _)| is_left(id));
        } else if let (Some(_), Some(list)) = (exchange.response("UAV-LIST"), list) {
            for (id, location) in listed.doubted.drain(..).filter(|(id, _)| list.contains(id)) {
                context.violation("UAV-INF", location, || {
                    let id = body::quoted(&id);
                    Detail::new(format!("{id} isn't known, and UAV-LIST has it before and after"))
                        .expected("a state")
                        .actual("an error")
                });
            }
            listed.uavs = list;
        }
    }

    fn corruption(&mut self, _: Location) {
        self.connections.clear();
    }
}

impl Unknown {
    /// UAVs that UAV-INF doesn't know if the request has their id twice.
    pub(super) fn to_repeated_ids() -> Self {
        Self { is_of_repeated: true, ..Self::default() }
    }

    /// UAV-INF tells of UAVs.
    fn inform(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let Some(request) = exchange.same_type_request() else { return };
        let is_repeated = request.repeated.is_some() && exchange.tried(&uav_inf_07::RULE.rule).is_some();
        if is_repeated != self.is_of_repeated {
            return;
        }
        let listed = self.connections.get(exchange);
        let known = request.objects.iter().flatten().filter(|id| listed.uavs.contains(*id));
        let unknown = body::members(exchange.body, "error");
        for id in known {
            context.covered();
            let is_doubted = unknown.iter().any(|(unknown, _)| unknown == id);
            if is_doubted && listed.doubted.len() < MAX_DOUBTED {
                listed.doubted.push((id.clone(), exchange.record.location));
            }
        }
    }
}
