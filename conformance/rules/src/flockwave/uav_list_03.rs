//! `FW-UAV-LIST-03`.
//!
//! UAVs come and go. A UAV therefore counts as missing from UAV-INF only under two conditions: the lists before and
//! after UAV-INF contain the UAV, and no OBJ-DEL in between names the UAV.

use std::collections::BTreeSet;

use super::prelude::*;
use crate::limits::MAX_UNKNOWN;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-LIST-03",
    name: "Listed UAVs have a state",
    level: Level::Info,
    status: Status::Advisory,
    statement: "UAV-INF returns the state of each UAV that UAV-LIST contains.",
    source: source::DERIVED,
    applies_to: "UAV-LIST and UAV-INF over time",
    why: "Clients list the UAVs and then query their states. If UAV-INF reports a UAV as unknown, the UAV \
          stays on the display without a position.",
    example: r#"→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}
→ {"type":"UAV-INF","ids":["uav-1"]}
← {"type":"UAV-INF","error":{"uav-1":"Unknown UAV"}}
→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}"#,
    fix: "Use the same registry for UAV-LIST and UAV-INF. Return the last known state of a UAV, even if \
          it is old.",
})
.checks(&[Check::Session(|| Box::new(Unknown::default()))])
.bug(Bug::message("UAV-LIST and OBJ-LIST contain a UAV that UAV-INF reports as unknown.", |out| {
    let has_uavs = match out.kind() {
        "UAV-LIST" => true,
        "OBJ-LIST" => {
            let filter = out.request.and_then(|body| body.get("filter")).and_then(Value::as_array);
            filter.is_none_or(|kinds| kinds.contains(&json!("uav")))
        }
        _ => false,
    };
    if has_uavs && let Some(ids) = out.message()["body"]["ids"].as_array_mut() {
        ids.push(json!("wraith-1"));
    }
}))
.mutants(&[Mutant::connection("an unknown UAV in the list", "tcp#9", |session| {
    let list = |session: &mut Session| {
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] }));
    };
    list(session);
    let error = json!({ "error": { "kite": "No such glider" } });
    session.exchange(json!({ "type": "UAV-INF", "ids": ["kite"] }), error);
    list(session);
})]);

/// UAVs that UAV-INF reports as unknown, by connection.
#[derive(Default)]
struct Unknown {
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
