//! `FW-ENV-22`.
//!
//! The probe sends a malformed request and then a valid one. Any response to either request is accepted.

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
        statement: "A malformed request with an id is answered, and the connection stays usable.",
        source: source::DERIVED,
        applies_to: "probe requests that test this rule",
        why: "A server that mishandles a malformed request may end the client's session or hang for all clients.",
        example: r#"→ {"$fw.version":"1.0","id":"c1","body":"SYS-PING"}
(the server closes the connection without a response)"#,
        fix: "Catch decoding errors for each message. Answer with ACK-NAK and the reason, then continue with the \
              next message.",
    },
    checks: &[Check::Exchange(|exchange, context| {
        served::tried(exchange, context);
    })],
    covers: &[],
    bug: Bug::behaviour("A malformed request ends the connection."),
    trial: Some(Trial::Attempts(Strain::Malformed, |_| attempts())),
    mutants: &[
        Mutant {
            name: "no response to a malformed request",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.tries_with(&RULE.rule, "a malformed request", ("body", json!(7)), None);
                })
            },
            also: &[],
        },
        Mutant {
            name: "no response to the next request",
            make: || mutant::unanswered("tcp#9", &RULE.rule),
            also: &[],
        },
    ],
};

/// The id of malformed requests.
const ID: &str = "malformed";

/// An attempt for each kind of malformed request.
fn attempts() -> Vec<Attempt> {
    let attempt = |request: Malformed| {
        let first = Sent::text(request.text, request.has_id.then_some(ID));
        Attempt::new(request.how, [Step::Send(first), Step::request("next")])
    };
    malformed::all(ID).into_iter().map(attempt).collect()
}
