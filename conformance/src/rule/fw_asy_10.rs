//! `FW-ASY-10`.
//!
//! That an operation isn't at its end when a recording ends says nothing.

use serde_json::json;

use super::fw::{self, Role, Stage, Turn};
use super::{Check, Detail, Judged, Level, Mutant, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "FW-ASY-10",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each receipt ends in one ASYNC-RESP or ASYNC-TIMEOUT, and no more.",
    source: fw::ASYNC,
    applies_to: "ASYNC-* over time",
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "a result after the timeout",
            make: |_| {
                fw::then(|talk| {
                    talk.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-2", "result": "Flaps out" }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a second result",
            make: |_| {
                fw::then(|talk| talk.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "result": true })))
            },
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, judged: &mut Judged<'_>) {
    if !matches!(turn.type_name, Some("ASYNC-RESP" | "ASYNC-TIMEOUT")) || turn.role != Role::Notification {
        return;
    }
    for named in turn.operations.iter().filter(|_| turn.exchange.connection.is_told) {
        judged.exercise();
        if named.stage() == Some(Stage::Ended) {
            turn.breaks(judged, || {
                Detail::new(format!("the end of {} was told already", fw::quoted(&named.receipt))).at("/body")
            });
        }
    }
}
