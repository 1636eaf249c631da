//! `FW-SYS-CLOSE-01`.

use serde_json::json;

use super::fw::{self, Exchange, Role, Shape};
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
                fw::then(|session| {
                    let id = session.sends(json!({ "type": "UAV-SOAR" }));
                    session.answers(&id, json!({ "body": { "type": "SYS-CLOSE" } }));
                })
            },
            also: &["FW-SYS-CLOSE-02"],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-CLOSE").is_none() {
        return;
    }
    context.covered();
    if exchange.role != Role::Notification {
        exchange.breaks(context, || Detail::new("it has `refs`, and is a notification"));
    }
    fw::field(exchange, context, "reason", false, &Shape::Nullable(&Shape::Text));
}
