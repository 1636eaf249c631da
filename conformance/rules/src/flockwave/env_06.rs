//! `FW-ENV-06`.
//!
//! Requests that were sent before the recording started are unknown. The rule therefore checks only connections whose
//! start was recorded, and only until the client sends text whose id is unknown.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-06",
    name: "Responses refer to requests",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `refs` of a response is the id of a request that was sent on the same connection.",
    source: source::GENERAL,
    applies_to: "responses over time",
    why: "The client cannot match the response to a request. The client drops the response, and the \
          request times out.",
    example: r#"→ {"$fw.version":"1.0","id":"C1","body":{"type":"SYS-PING"}}
← {"$fw.version":"1.0","id":"s1","refs":"c1","body":{"type":"ACK-ACK"}}"#,
    fix: "Copy the `id` of the request to `refs` byte for byte, and send the response on the same \
          connection.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("Each SYS-VER response is followed by an ACK-ACK that refers to no request.", |out| {
    if out.kind() == "SYS-VER" {
        out.follow(Some("nobody-sent-this"), json!({ "type": "ACK-ACK" }));
    }
}))
.mutants(&[Mutant::session("a response without a request", |session| {
    session.answers("nobody", json!({ "body": { "type": "ACK-ACK" } }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !reply::refers(exchange) {
        return;
    }
    context.covered();
    // FW-ENV-05 reports `refs` that is not a string.
    if let Some(refs) = exchange.refs.filter(|_| exchange.reference == Reference::Unknown) {
        exchange.violates(context, || {
            let refs = body::quoted(refs);
            Detail::new(format!("no request on this connection has the id {refs}")).at("/refs")
        });
    }
}
