//! `FW-ENV-12`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, INTEGER, Level, Mutant, Rule, RuleContext, Shape, Status,
    Tree, fw,
};

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
    covers: &[],
    bug: Bug::message("Requests of unknown types are answered by an error that says nothing.", |out| {
        if out.refuses_unknown_type()
            && let Some(message) = out.message().as_object_mut()
        {
            message.remove("body");
            message.insert("error".to_owned(), json!({}));
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "an empty error",
            make: || {
                fw::then(|session| {
                    let id = session.sends(json!({ "type": "LCN-INF" }));
                    session.answers(&id, json!({ "error": {} }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a code that is a string",
            make: || {
                fw::then(|session| {
                    let id = session.sends(json!({ "type": "LCN-INF" }));
                    session.answers(&id, json!({ "error": { "code": "three", "message": "No" } }));
                })
            },
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(error) = exchange.message().and_then(|message| message.get("error")) else { return };
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
        exchange.breaks(context, || {
            Detail::differs("an integer `code`, a string `message`, or both", error).at("/error")
        });
    }
}
