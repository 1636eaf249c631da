//! `FW-ENV-01`.

use serde_json::json;

use super::fw::{self, Conversation, Role, Turn};
use super::{Check, Detail, Judged, Level, Mutant, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "FW-ENV-01",
    level: Level::Must,
    status: Status::Normative,
    statement: "A message is one JSON object.",
    source: fw::GENERAL,
    applies_to: "messages of the server",
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "what the server sends is no JSON",
            make: |_| {
                let mut talk = Conversation::new();
                talk.lines
                    .push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "raw": "{\"$fw.version\":" }));
                Some(talk.to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "a list",
            make: |_| {
                let mut talk = Conversation::new();
                talk.lines.push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "msg": [1] }));
                Some(talk.to_bytes())
            },
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, judged: &mut Judged<'_>) {
    if !turn.is_of_server() {
        return;
    }
    judged.exercise();
    if turn.role == Role::Unreadable {
        turn.breaks(judged, || match turn.exchange.value {
            Some(value) => Detail::differs("an object", value),
            None => Detail::new("no JSON").expected("an object"),
        });
    }
}
