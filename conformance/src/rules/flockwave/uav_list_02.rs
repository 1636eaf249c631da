//! `FW-UAV-LIST-02`.
//!
//! UAVs come and go. So the lists differ only where those of UAV-LIST before and after that of OBJ-LIST are the same.

use std::collections::BTreeSet;

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Rule, RuleContext,
    SessionCheck, Status, body, mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "UAV-LIST has the objects that OBJ-LIST has for the type `uav`.",
        source: source::MESSAGES,
        applies_to: "UAV-LIST and OBJ-LIST over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Uavs::default()))],
    covers: &[],
    bug: Bug::message("UAV-LIST lacks its last UAV.", |out| {
        if let Some(ids) = out.ids_of("UAV-LIST") {
            ids.pop();
        }
    }),
    trial: None,
    mutants: &[
        Mutant { name: "UAV-LIST lacks one", make: || listed(&["kite"], &["kite", "swift"]), also: &[] },
        Mutant { name: "UAV-LIST has one more", make: || listed(&["kite", "owl"], &["kite"]), also: &[] },
    ],
};

/// These are listed by UAV-LIST before and after those by OBJ-LIST.
fn listed(uavs: &[&str], objects: &[&str]) -> Option<Vec<u8>> {
    mutant::over("tcp#9", |session| {
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": uavs }));
        session.exchange(json!({ "type": "OBJ-LIST", "filter": ["uav"] }), json!({ "ids": objects }));
        session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": uavs }));
    })
}

/// How many lists of OBJ-LIST are kept until the next one of UAV-LIST.
const MAX_LISTS: usize = 4;

/// What was listed, connection by connection.
#[derive(Default)]
struct Uavs(PerConnection<Listed>);

/// What was listed on a connection.
#[derive(Default)]
struct Listed {
    /// The latest list of UAV-LIST.
    uavs: Option<BTreeSet<String>>,
    /// The lists of OBJ-LIST since.
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
            let is_of_uavs = |filter: &BTreeSet<String>| filter.len() == 1 && filter.contains("uav");
            if request.filter.as_ref().is_some_and(is_of_uavs) && listed.objects.len() < MAX_LISTS {
                listed.objects.push((list, exchange.record.location));
            }
        } else if exchange.response("UAV-LIST").is_some() {
            let objects = std::mem::take(&mut listed.objects);
            if listed.uavs.as_ref() == Some(&list) {
                for (objects, location) in objects {
                    compare(&list, &objects, location, context);
                }
            }
            listed.uavs = Some(list);
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
            let (has, lacks) =
                if objects.contains(id) { ("OBJ-LIST", "UAV-LIST") } else { ("UAV-LIST", "OBJ-LIST") };
            let id = body::quoted(id);
            Detail::new(format!("{has} has {id}, and {lacks} hasn't, before and after"))
        });
    }
}
