//! `FW-ENV-22`.
//!
//! It is tried with two requests: one that is malformed, to which any answer will do; and a sound one after it,
//! of a type that has nothing to get wrong, which has to be served.

use serde_json::json;

use super::fw::{self, Turn};
use super::{Check, Judged, Level, Mutant, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "FW-ENV-22",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A malformed request that has an id gets an answer, and the connection goes on.",
    source: fw::DERIVED,
    applies_to: "requests that try it",
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "no answer to a malformed request",
            make: |_| {
                fw::over("tcp#9", |talk| {
                    talk.tries_with("FW-ENV-22", "a malformed request", ("body", json!(7)), None);
                })
            },
            also: &[],
        },
        Mutant {
            name: "no answer to the request after it",
            make: |_| fw::unanswered("tcp#9", "FW-ENV-22"),
            also: &[],
        },
        Mutant {
            name: "the request after it is refused",
            make: |_| fw::refused("tcp#9", "FW-ENV-22"),
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, judged: &mut Judged<'_>) {
    let Some(asked) = &turn.asked else { return };
    let is_sound = asked.is_sound && matches!(asked.type_name.as_deref(), Some("SYS-PING" | "SYS-VER"));
    if is_sound {
        fw::served(turn, judged);
    } else {
        fw::tried(turn, judged);
    }
}
