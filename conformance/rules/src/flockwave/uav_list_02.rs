//! `FW-UAV-LIST-02`.
//!
//! UAVs come and go. The lists are therefore compared only if the UAV-LIST responses before and after the OBJ-LIST
//! response are equal. Their times must be known, and the two responses must be at most ten seconds apart.

use std::collections::BTreeSet;

use super::prelude::*;
use super::reply::TimedList;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-LIST-02",
    name: "UAV-LIST agrees with OBJ-LIST",
    level: Level::Must,
    status: Status::Normative,
    statement: "UAV-LIST contains the same objects as OBJ-LIST with the filter `uav`.",
    source: source::MESSAGES,
    applies_to: "UAV-LIST and OBJ-LIST over time",
    why: "Some clients load the fleet with UAV-LIST, others with OBJ-LIST. If the lists differ, operators \
          at two consoles see different fleets.",
    example: r#"→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}
→ {"type":"OBJ-LIST","filter":["uav"]}
← {"type":"OBJ-LIST","ids":["uav-1","uav-2"]}
→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1"]}"#,
    fix: "Answer both requests from the same registry, for example by handling UAV-LIST as OBJ-LIST with \
          the filter `uav`.",
})
.checks(&[Check::Session(|| Box::new(Uavs::default()))])
.bug(Bug::message("UAV-LIST omits its last UAV.", |out| {
    if let Some(ids) = out.ids_of("UAV-LIST") {
        ids.pop();
    }
}))
.mutants(&[
    Mutant::connection("UAV-LIST omits a UAV", "tcp#9", |session| {
        lists(session, &["kite"], &["kite", "swift"]);
    }),
    Mutant::connection("UAV-LIST has an additional UAV", "tcp#9", |session| {
        lists(session, &["kite", "owl"], &["kite"]);
    }),
]);

/// Adds responses with `uavs` in UAV-LIST, `objects` in OBJ-LIST, and `uavs` in UAV-LIST again.
fn lists(session: &mut Session, uavs: &[&str], objects: &[&str]) {
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": uavs }));
    session.exchange(json!({ "type": "OBJ-LIST", "filter": ["uav"] }), json!({ "ids": objects }));
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": uavs }));
}

/// The maximum number of OBJ-LIST responses that are stored until the next UAV-LIST.
const MAX_LISTS: usize = 4;

/// The listed UAVs, by connection.
#[derive(Default)]
struct Uavs(PerConnection<Listed>);

/// The listed UAVs of a connection.
#[derive(Default)]
struct Listed {
    /// The latest UAV-LIST.
    uavs: Option<TimedList>,
    /// The ids and locations of OBJ-LIST responses since the latest UAV-LIST.
    objects: Vec<(BTreeSet<String>, Location)>,
}

impl SessionCheck for Uavs {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        if exchange.notification("OBJ-DEL").is_some() {
            return *self.0.get(exchange) = Listed::default();
        }
        let Some(list) = reply::listed(exchange) else { return };
        let listed = self.0.get(exchange);
        if let Some(request) = exchange.response("OBJ-LIST").and(exchange.same_type_request()) {
            let is_uav_filter = |filter: &BTreeSet<String>| filter.len() == 1 && filter.contains("uav");
            if request.filter.as_ref().is_some_and(is_uav_filter) && listed.objects.len() < MAX_LISTS {
                listed.objects.push((list, exchange.record.location));
            }
        } else if exchange.response("UAV-LIST").is_some() {
            let objects = std::mem::take(&mut listed.objects);
            if listed.uavs.as_ref().is_some_and(|uavs| uavs.is_confirmed_by(&list, exchange)) {
                for (objects, location) in objects {
                    compare(&list, &objects, location, context);
                }
            }
            listed.uavs = Some(TimedList::new(list, exchange));
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

fn compare(
    uavs: &BTreeSet<String>,
    objects: &BTreeSet<String>,
    location: Location,
    context: &mut RuleContext<'_>,
) {
    context.covered();
    if let Some(id) = uavs.symmetric_difference(objects).next() {
        context.violation("UAV-LIST", location, || {
            let (complete, incomplete) =
                if objects.contains(id) { ("OBJ-LIST", "UAV-LIST") } else { ("UAV-LIST", "OBJ-LIST") };
            let id = body::quoted(id);
            Detail::new(format!("{complete} contains {id}, but {incomplete} does not"))
        });
    }
}
