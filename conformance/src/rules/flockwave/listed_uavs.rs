//! Checks UAV-INF against the UAVs in UAV-LIST.
//!
//! UAVs come and go. A UAV therefore counts as missing from UAV-INF only under two conditions. The lists before and
//! after UAV-INF contain the UAV, and no OBJ-DEL in between names the UAV.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Detail, Exchange, Location, PerConnection, RuleContext, Session, SessionCheck, body, reply};

/// Adds records between two UAV-LIST exchanges with the same UAVs.
pub(super) fn listed_twice(session: &mut Session, add: impl FnOnce(&mut Session)) {
    let list = || -> (Value, Value) { (json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] })) };
    let (request, answer) = list();
    session.exchange(request, answer);
    add(session);
    let (request, answer) = list();
    session.exchange(request, answer);
}

/// The maximum number of stored unknown UAVs per connection.
const MAX_UNKNOWN: usize = 1_000;

/// UAVs that UAV-INF reports as unknown, by connection.
#[derive(Default)]
pub(super) struct Unknown {
    connections: PerConnection<Listed>,
}

/// The UAVs that were listed on a connection.
#[derive(Default)]
struct Listed {
    /// The latest list.
    uavs: BTreeSet<String>,
    /// UAVs in the latest list that UAV-INF reports as unknown, each with the location of the UAV-INF response.
    unknown: Vec<(String, Location)>,
}

impl SessionCheck for Unknown {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        if exchange.response("UAV-INF").is_some() {
            return self.uav_inf(exchange, context);
        }
        let list = reply::listed(exchange);
        let listed = self.connections.get(exchange);
        if exchange.notification("OBJ-DEL").is_some() {
            let is_present = |id: &String| list.as_ref().is_some_and(|deleted| !deleted.contains(id));
            listed.uavs.retain(is_present);
            listed.unknown.retain(|(id, _)| is_present(id));
        } else if let (Some(_), Some(list)) = (exchange.response("UAV-LIST"), list) {
            for (id, location) in listed.unknown.drain(..).filter(|(id, _)| list.contains(id)) {
                context.violation("UAV-INF", location, || {
                    let id = body::quoted(&id);
                    Detail::new(format!(
                        "UAV-INF reports {id} as unknown, but the UAV-LIST responses before and after it contain {id}"
                    ))
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
    /// Processes a UAV-INF response.
    fn uav_inf(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let Some(request) = exchange.same_type_request() else { return };
        // The ids must be unique, so a server may report a repeated id as an error.
        if request.repeated.is_some() {
            return;
        }
        let listed = self.connections.get(exchange);
        let known = request.objects.iter().flatten().filter(|id| listed.uavs.contains(*id));
        let errors = body::members(exchange.body, "error");
        for id in known {
            context.covered();
            let is_unknown = errors.iter().any(|(key, _)| key == id);
            if is_unknown && listed.unknown.len() < MAX_UNKNOWN {
                listed.unknown.push((id.clone(), exchange.record.location));
            }
        }
    }
}
