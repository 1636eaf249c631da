//! `FW-SYS-TIME-02`.
//!
//! A request that sets the clock gives another offset, and nothing is known of it then.

use serde_json::json;

use super::fw::{self, Conversation, Turn};
use super::{Check, Detail, Judged, Level, Mutant, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "FW-SYS-TIME-02",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The time that a server tells lies between sending the request and receiving the answer, but for an offset that stays the same.",
    source: fw::DERIVED,
    applies_to: "SYS-TIME over time",
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "the second answer is ahead",
            make: |_| {
                let later = |talk: &mut Conversation| {
                    talk.asks(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1_800_000_000_000_u64 }));
                };
                fw::then(later)
            },
            also: &[],
        },
        Mutant {
            name: "the time goes back",
            make: |_| {
                let before = |talk: &mut Conversation| {
                    talk.asks(json!({ "type": "SYS-TIME" }), json!({ "timestamp": 1_780_000_000_000_u64 }));
                };
                fw::then(before)
            },
            also: &[],
        },
    ],
};

/// How much clocks may drift apart from one answer to the next, in seconds.
const TOLERANCE: f64 = 1.0;

fn judge(turn: &Turn<'_>, judged: &mut Judged<'_>) {
    let (Some(now), Some(before)) = (turn.clock_reading(), turn.clock) else { return };
    judged.exercise();
    // An offset that both answers allow.
    let apart = (now.0 - before.1).max(before.0 - now.1);
    if apart > TOLERANCE {
        turn.breaks(judged, || {
            Detail::new(format!("the server's clock has moved by {apart:.1} s against that of the recording"))
                .at("/body/timestamp")
        });
    }
}
