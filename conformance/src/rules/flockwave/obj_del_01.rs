//! `FW-OBJ-DEL-01`.

use serde_json::json;

use super::fw::{self, Role, Shape, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

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
    mutants: &[
        Mutant {
            name: "no ids",
            make: || fw::notice("OBJ-DEL", |body| *body = json!({ "type": "OBJ-DEL" })),
            also: &[],
        },
        Mutant {
            name: "as an answer",
            make: || {
                fw::then(|talk| {
                    let id = talk.sends(json!({ "type": "UAV-SOAR" }));
                    talk.answers(&id, json!({ "body": { "type": "OBJ-DEL", "ids": ["vane"] } }));
                })
            },
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.body_of("OBJ-DEL").is_none() {
        return;
    }
    context.covered();
    if turn.role != Role::Notification {
        turn.breaks(context, || Detail::new("it has `refs`, and is a notification"));
    }
    fw::field(turn, context, "ids", true, &Shape::List(&Shape::Text));
}
