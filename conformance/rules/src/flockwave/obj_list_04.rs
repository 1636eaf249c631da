//! `FW-OBJ-LIST-04`.
//!
//! Objects come and go. An object of a filtered list therefore counts as missing only under two conditions: the
//! unfiltered lists before and after the filtered list are equal, and no notification in between reports the object as
//! deleted. The rule compares the lists only if their times are known, and if the unfiltered lists are at most ten
//! seconds apart.

use std::collections::BTreeSet;

use super::prelude::*;
use super::reply::TimedList;
use crate::limits::MAX_OBJECTS;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-LIST-04",
    name: "List without a filter",
    level: Level::Must,
    status: Status::Normative,
    statement: "OBJ-LIST without a filter lists all objects.",
    source: source::MESSAGES,
    applies_to: "OBJ-LIST over time",
    why: "Clients use this request to load the initial state of the fleet. They never show an object that \
          is missing from the response.",
    example: r#"→ {"type":"OBJ-LIST"}
← {"type":"OBJ-LIST","ids":["uav-1"]}
→ {"type":"OBJ-LIST","filter":["beacon"]}
← {"type":"OBJ-LIST","ids":["mast-1"]}
→ {"type":"OBJ-LIST"}
← {"type":"OBJ-LIST","ids":["uav-1"]}"#,
    fix: "Return the objects of all types if the request has no `filter`.",
})
.checks(&[Check::Session(|| Box::new(Objects::default()))])
.bug(Bug::behaviour("OBJ-LIST without a filter lists UAVs only."))
.mutants(&[Mutant::connection("the objects of one type are missing", "tcp#9", |session| {
    let all = || json!({ "ids": ["kite", "swift"] });
    let masts = json!({ "type": "OBJ-LIST", "filter": ["beacon"] });
    session.exchange(json!({ "type": "OBJ-LIST" }), all());
    session.exchange(masts, json!({ "ids": ["mast"] }));
    session.exchange(json!({ "type": "OBJ-LIST" }), all());
})]);

/// The listed objects, by connection.
#[derive(Default)]
struct Objects(PerConnection<Listed>);

/// The listed objects of a connection.
#[derive(Default)]
struct Listed {
    /// The latest unfiltered list.
    all: Option<TimedList>,
    /// The objects in filtered lists since the latest unfiltered list.
    others: BTreeSet<String>,
}

impl SessionCheck for Objects {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        let is_deletion =
            exchange.notification("OBJ-DEL").or_else(|| exchange.notification("CONN-DEL")).is_some();
        if is_deletion {
            let deleted = reply::listed(exchange);
            let is_present = |id: &String| deleted.as_ref().is_some_and(|deleted| !deleted.contains(id));
            return self.0.get(exchange).others.retain(is_present);
        }
        let request = exchange.response("OBJ-LIST").and(exchange.same_type_request());
        let (Some(request), Some(list)) = (request, reply::listed(exchange)) else { return };
        let listed = self.0.get(exchange);
        match &request.filter {
            Some(filter) if filter.is_empty() => {}
            Some(_) if listed.others.len() + list.len() <= MAX_OBJECTS => listed.others.extend(list),
            Some(_) => {}
            None => {
                let others = std::mem::take(&mut listed.others);
                if listed.all.as_ref().is_some_and(|all| all.is_confirmed_by(&list, exchange)) {
                    if !others.is_empty() {
                        context.covered();
                    }
                    if let Some(id) = others.difference(&list).next() {
                        exchange.violates(context, || {
                            let id = body::quoted(id);
                            Detail::new(format!("{id} is missing, but a filtered list contains it"))
                                .at("/body/ids")
                        });
                    }
                }
                listed.all = Some(TimedList::new(list, exchange));
            }
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}
