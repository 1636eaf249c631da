//! `FW-ENV-09`.

use serde_json::json;

use super::fw::{self, Conversation, Reference, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-09",
        level: Level::Must,
        status: Status::Normative,
        statement: "`refs` never names a notification.",
        source: fw::GENERAL,
        applies_to: "responses over time",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "a response to a notification",
        make: || {
            let mut talk = Conversation::opened();
            talk.tells(json!({ "type": "SYS-MSG", "items": [{ "message": "Wind from the west" }] }));
            talk.answers("say-1", json!({ "body": { "type": "ACK-ACK" } }));
            Some(talk.to_bytes())
        },
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if !fw::refers(turn) {
        return;
    }
    context.covered();
    if turn.reference == Reference::Notification {
        turn.breaks(context, || {
            let refs = turn.refs.map(fw::quoted).unwrap_or_default();
            Detail::new(format!("{refs} is a notification of the server itself")).at("/refs")
        });
    }
}
