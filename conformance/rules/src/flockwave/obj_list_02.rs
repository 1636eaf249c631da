//! `FW-OBJ-LIST-02`.

use std::collections::{BTreeMap, BTreeSet};

use super::prelude::*;
use super::{obj_list_03, uav_list_02};

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-LIST-02",
    name: "Filter by type",
    level: Level::Should,
    status: Status::Advisory,
    statement: "A filtered OBJ-LIST contains only objects of the requested types, so no object is listed \
                under two types.",
    source: source::MESSAGES,
    applies_to: "OBJ-LIST over time",
    why: "Clients use the filter to find UAVs. If the server ignores the filter, clients treat beacons or \
          docks as UAVs and send flight commands to them.",
    example: r#"→ {"type":"OBJ-LIST","filter":["uav"]}
← {"type":"OBJ-LIST","ids":["uav-1","mast-1"]}
→ {"type":"OBJ-LIST","filter":["beacon"]}
← {"type":"OBJ-LIST","ids":["uav-1","mast-1"]}"#,
    fix: "Apply `filter` to the type of each object. Give each object one type.",
})
.checks(&[Check::Session(|| Box::new(Listed::default()))])
.bug(Bug::behaviour("OBJ-LIST ignores its filter.").also(&[&obj_list_03::RULE.rule, &uav_list_02::RULE.rule]))
.mutants(&[Mutant::connection("an ignored filter", "tcp#9", |session| {
    for kind in ["uav", "beacon"] {
        let all = json!({ "ids": ["kite", "mast", "swift"] });
        session.exchange(json!({ "type": "OBJ-LIST", "filter": [kind] }), all);
    }
})]);

/// The maximum number of stored lists per connection.
const MAX_KINDS: usize = 8;

/// The latest list for each type, by connection.
#[derive(Default)]
struct Listed(PerConnection<BTreeMap<String, BTreeSet<String>>>);

impl SessionCheck for Listed {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        if exchange.notification("OBJ-DEL").is_some() {
            // A new object may have the id of a deleted object, but a different type.
            let deleted = reply::listed(exchange);
            let is_present = |id: &String| deleted.as_ref().is_some_and(|deleted| !deleted.contains(id));
            self.0.get(exchange).values_mut().for_each(|list| list.retain(is_present));
            return;
        }
        let request = exchange.response("OBJ-LIST").and(exchange.same_type_request());
        // FW-OBJ-LIST-03 checks unknown types.
        let request = request.filter(|_| exchange.tried(&obj_list_03::RULE.rule).is_none());
        let Some(filter) =
            request.and_then(|request| request.filter.as_ref()).filter(|filter| filter.len() == 1)
        else {
            return;
        };
        let (Some(kind), Some(list)) = (filter.first(), reply::listed(exchange)) else { return };
        let lists = self.0.get(exchange);
        for (other, known) in lists.iter().filter(|(other, _)| *other != kind) {
            // Without objects, a filter has no effect.
            if list.is_empty() && known.is_empty() {
                continue;
            }
            context.covered();
            if let Some(id) = list.intersection(known).next() {
                exchange.violates(context, || {
                    let (id, kind, other) = (body::quoted(id), body::quoted(kind), body::quoted(other));
                    Detail::new(format!(
                        "{id} is listed for type {kind}, but an earlier response lists it for type \
                                         {other}"
                    ))
                    .at("/body/ids")
                });
            }
        }
        if lists.len() < MAX_KINDS || lists.contains_key(kind) {
            lists.insert(kind.clone(), list);
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}
