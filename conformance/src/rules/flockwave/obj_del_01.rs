//! `FW-OBJ-DEL-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Shape,
    Status, attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-OBJ-DEL-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "OBJ-DEL is a notification with `ids`, a list of strings.",
        source: fw::MESSAGES,
        applies_to: "OBJ-DEL",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["OBJ-DEL"], "ids", attribution::MISSING),
        Attribution::new(&["OBJ-DEL"], "ids.*", attribution::MISSING),
    ],
    bug: Bug::message("OBJ-DEL has its ids as a text.", |out| {
        if let Some(body) = out.body_of("OBJ-DEL") {
            body["ids"] = body["ids"][0].take();
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "no ids",
            make: || fw::notice("OBJ-DEL", |body| *body = json!({ "type": "OBJ-DEL" })),
            also: &[],
        },
        Mutant {
            name: "as an answer",
            make: || {
                fw::then(|session| {
                    let id = session.sends(json!({ "type": "UAV-SOAR" }));
                    session.answers(&id, json!({ "body": { "type": "OBJ-DEL", "ids": ["vane"] } }));
                })
            },
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("OBJ-DEL").is_none() {
        return;
    }
    context.covered();
    if exchange.role != Role::Notification {
        exchange.breaks(context, || Detail::new("it has `refs`, and is a notification"));
    }
    fw::field(exchange, context, "ids", true, &Shape::List(&Shape::Text));
}
