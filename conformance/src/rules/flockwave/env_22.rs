//! `FW-ENV-22`.
//!
//! It is tried with two requests: one that is malformed, and a sound one after it. To either any answer will do.

use serde_json::json;

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Malformed, Mutant, Rule, Sent, Status, Step, Strain, Trial,
    malformed, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-22",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A malformed request that has an id gets an answer, and the connection goes on.",
        source: source::DERIVED,
        applies_to: "requests that try it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(|exchange, context| {
        served::tried(exchange, context);
    })],
    covers: &[],
    bug: Bug::behaviour("A request that is malformed ends the connection."),
    trial: Some(Trial::Attempts(Strain::Malformed, |_| attempts())),
    mutants: &[
        Mutant {
            name: "no answer to a malformed request",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.tries_with(&RULE.rule, "a malformed request", ("body", json!(7)), None);
                })
            },
            also: &[],
        },
        Mutant {
            name: "no answer to the request after it",
            make: || mutant::unanswered("tcp#9", &RULE.rule),
            also: &[],
        },
    ],
};

/// The id of malformed requests.
const ID: &str = "malformed";

/// An attempt for each kind of malformed request.
fn attempts() -> Vec<Attempt> {
    let attempt = |of: Malformed| {
        let first = Sent::text(of.text, of.has_id.then_some(ID));
        Attempt::new(of.how, [Step::Send(first), Step::request("next")])
    };
    malformed::all(ID).into_iter().map(attempt).collect()
}
