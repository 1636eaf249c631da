//! `FW-OBJ-LIST-04`.
//!
//! Objects come and go. So an object is missing only where the lists of all objects before and after one with a filter are
//! the same, and nothing has told in between that it is gone.

use std::collections::BTreeSet;

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Rule, RuleContext,
    SessionCheck, Status, body, mutant, reply, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-OBJ-LIST-04",
        level: Level::Must,
        status: Status::Normative,
        statement: "Without a filter OBJ-LIST has all objects.",
        source: source::MESSAGES,
        applies_to: "OBJ-LIST over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Objects::default()))],
    covers: &[],
    bug: Bug::behaviour("OBJ-LIST without a filter has UAVs only."),
    trial: None,
    mutants: &[Mutant {
        name: "those of one type are missing",
        make: || {
            let all = || json!({ "ids": ["kite", "swift"] });
            let masts = json!({ "type": "OBJ-LIST", "filter": ["beacon"] });
            mutant::over("tcp#9", |session| {
                session.exchange(json!({ "type": "OBJ-LIST" }), all());
                session.exchange(masts, json!({ "ids": ["mast"] }));
                session.exchange(json!({ "type": "OBJ-LIST" }), all());
            })
        },
        also: &[],
    }],
};

/// How many objects are kept of lists with a filter.
const MAX_OBJECTS: usize = 10_000;

/// What was listed, connection by connection.
#[derive(Default)]
struct Objects(PerConnection<Listed>);

/// What was listed on a connection.
#[derive(Default)]
struct Listed {
    /// The latest list without a filter.
    all: Option<BTreeSet<String>>,
    /// What lists with a filter have had since.
    others: BTreeSet<String>,
}

impl SessionCheck for Objects {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        let is_end = exchange.notification("OBJ-DEL").or_else(|| exchange.notification("CONN-DEL")).is_some();
        if is_end {
            let gone = reply::listed(exchange);
            let is_left = |id: &String| gone.as_ref().is_some_and(|gone| !gone.contains(id));
            return self.0.get(exchange).others.retain(is_left);
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
                if listed.all.as_ref() == Some(&list) {
                    if !others.is_empty() {
                        context.covered();
                    }
                    if let Some(id) = others.difference(&list).next() {
                        exchange.violates(context, || {
                            let id = body::quoted(id);
                            Detail::new(format!("{id} is missing, which a list with a filter has"))
                                .at("/body/ids")
                        });
                    }
                }
                listed.all = Some(list);
            }
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}
