//! `FW-ENV-19`.
//!
//! It is the one rule on clients: what breaks it leaves nobody able to say which answer belongs to what. What servers do
//! with an id that is used again in its time is seen where someone tries it.

use serde_json::json;

use super::fw::{self, Role, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-19",
        level: Level::Must,
        status: Status::Normative,
        statement: "A client doesn't use the id of a request again while that is unanswered. Afterwards a server accepts it.",
        source: fw::GENERAL,
        applies_to: "requests over time",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "an id is used twice at the same time",
            make: || {
                fw::then(|talk| {
                    let id = talk.sends(json!({ "type": "SYS-PING" }));
                    let other = talk.sends(json!({ "type": "SYS-PING" }));
                    if let Some(line) = talk.lines.last_mut() {
                        line["msg"]["id"] = id.clone().into();
                    }
                    for _ in [&id, &other] {
                        talk.answers(&id, json!({ "body": { "type": "ACK-ACK" } }));
                    }
                })
            },
            also: &[],
        },
        Mutant {
            name: "an id that was answered is refused",
            make: || fw::refused("tcp#9", "FW-ENV-19"),
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    fw::served(turn, context);
    if turn.role != Role::Request || turn.is_of_server() || !turn.exchange.connection.is_told {
        return;
    }
    context.covered();
    if turn.is_id_in_use {
        turn.breaks(context, || {
            let id = turn.id.map(fw::quoted).unwrap_or_default();
            Detail::new(format!("another request with the id {id} waits for its answer")).at("/id")
        });
    }
}
