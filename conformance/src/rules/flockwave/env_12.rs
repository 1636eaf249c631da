//! `FW-ENV-12`.

use serde_json::json;

use super::fw::{self, INTEGER, Shape, Tree, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-12",
        level: Level::Must,
        status: Status::Normative,
        statement: "`error` of a message is an object with an integer `code`, a string `message`, or both.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "an empty error",
            make: || {
                fw::then(|talk| {
                    let id = talk.sends(json!({ "type": "LCN-INF" }));
                    talk.answers(&id, json!({ "error": {} }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a code that is a string",
            make: || {
                fw::then(|talk| {
                    let id = talk.sends(json!({ "type": "LCN-INF" }));
                    talk.answers(&id, json!({ "error": { "code": "three", "message": "No" } }));
                })
            },
            also: &[],
        },
    ],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    let Some(error) = turn.message().and_then(|message| message.get("error")) else { return };
    if *error == Tree::Null {
        return;
    }
    context.covered();
    let fits = |name: &str, shape: Shape| {
        let value = error.get(name).filter(|value| **value != Tree::Null)?;
        Some(shape.mismatch(value).is_none())
    };
    let (code, message) = (fits("code", INTEGER), fits("message", Shape::Text));
    if code == Some(false) || message == Some(false) || (code, message) == (None, None) {
        turn.breaks(context, || {
            Detail::differs("an integer `code`, a string `message`, or both", error).at("/error")
        });
    }
}
