//! `FW-ENV-22`.
//!
//! The probe sends a malformed request and then a valid one. The server may ignore the malformed request. Any response to
//! either request is accepted.

use super::malformed::{self, Malformed};
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-22",
    name: "Malformed requests do no harm",
    level: Level::Info,
    status: Status::Advisory,
    statement: "After a malformed request, the server keeps serving the connection. Over HTTP, it answers \
                the malformed request, at least with a status from 200 to 499.",
    source: source::DERIVED,
    applies_to: "probe requests that test this rule",
    why: "A server that mishandles a malformed request may end the client's session or hang for all clients.",
    example: r#"→ {"$fw.version":"1.0","id":"c1","body":"SYS-PING"}
→ {"type":"SYS-VER"}
(the server closes the connection without a response)"#,
    fix: "Catch decoding errors for each message. Answer with ACK-NAK and the reason if the request has \
          an id, then continue with the next message.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("A malformed request ends the connection."))
.trial(Trial::Attempts(Strain::Malformed, |_| attempts()))
.mutants(&[
    Mutant::unanswered("no response to the next request", "tcp#9"),
    Mutant::session("an HTTP request that fails", |session| {
        session.failed(&RULE.rule, "no body", "HTTP status 500");
    }),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served::tried(exchange, context);
    let how = exchange.tried(&RULE.rule).filter(|_| exchange.record.text == "failed");
    if let Some((how, why)) = how.zip(exchange.record.note) {
        context.covered();
        context.violation("HTTP", exchange.record.location, || {
            Detail::new(format!("{how}: {}", body::quoted(why))).expected("a response").actual("none")
        });
    }
}

/// The id of malformed requests that have a valid id.
const ID: &str = "malformed";

/// An attempt for each kind of malformed request.
fn attempts() -> Vec<Attempt> {
    let attempt = |request: Malformed| {
        let first = Sent::text(request.text, None);
        Attempt::new(request.how, [Step::Send(first), Step::request("next")])
    };
    malformed::all(ID).into_iter().map(attempt).collect()
}
