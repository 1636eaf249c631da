//! `FW-SYS-CLOSE-01`.

use serde_json::json;

use super::fw::{self, Role, Shape, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-CLOSE-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "SYS-CLOSE is a notification with an optional string `reason`.",
        source: fw::MESSAGES,
        applies_to: "SYS-CLOSE",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "a reason that is a number",
            make: || fw::notice("SYS-CLOSE", |body| body["reason"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "as an answer",
            make: || {
                fw::then(|talk| {
                    let id = talk.sends(json!({ "type": "UAV-SOAR" }));
                    talk.answers(&id, json!({ "body": { "type": "SYS-CLOSE" } }));
                })
            },
            also: &["FW-SYS-CLOSE-02"],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.body_of("SYS-CLOSE").is_none() {
        return;
    }
    context.covered();
    if turn.role != Role::Notification {
        turn.breaks(context, || Detail::new("it has `refs`, and is a notification"));
    }
    fw::field(turn, context, "reason", false, &Shape::Nullable(&Shape::Text));
}
