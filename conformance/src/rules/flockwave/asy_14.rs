//! `FW-ASY-14`.

use serde_json::json;

use super::fw::{self, Role, Stage, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-14",
        level: Level::Must,
        status: Status::Normative,
        statement: "A suspended operation doesn't end until the client resumes or cancels it.",
        source: fw::ASYNC,
        applies_to: "ASYNC-* over time",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "it ends by itself",
        make: || {
            fw::then(|talk| {
                talk.asks(
                    json!({ "type": "UAV-RTH", "ids": ["kite"] }),
                    json!({ "receipt": { "kite": "rcpt-8" } }),
                );
                talk.tells(json!({ "type": "ASYNC-ST", "id": "rcpt-8", "progress": {}, "suspended": true }));
                talk.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }));
            })
        },
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if !matches!(turn.type_name, Some("ASYNC-RESP" | "ASYNC-TIMEOUT")) || turn.role != Role::Notification {
        return;
    }
    for named in turn.operations.iter().filter(|_| turn.exchange.connection.is_told) {
        let Some(operation) = &named.before else { continue };
        context.covered();
        if operation.stage == Stage::Suspended {
            turn.breaks(context, || {
                Detail::new(format!(
                    "{} waits for the client, who has neither resumed nor cancelled it",
                    fw::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
