//! `FW-ENV-08`.

use serde_json::json;

use super::fw::{self, Reference, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-08",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A request gets one response at most.",
        source: fw::DERIVED,
        applies_to: "responses over time",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "a second answer",
        make: || {
            let answer = || json!({ "body": { "type": "ACK-ACK" } });
            fw::then(|talk| talk.answers("ask-2", answer()))
        },
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if !fw::refers(turn) {
        return;
    }
    context.covered();
    if turn.reference == Reference::Answered {
        turn.breaks(context, || {
            let refs = turn.refs.map(fw::quoted).unwrap_or_default();
            Detail::new(format!("the request {refs} has had its response already")).at("/refs")
        });
    }
}
