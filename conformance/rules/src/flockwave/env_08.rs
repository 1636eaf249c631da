//! `FW-ENV-08`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-08",
    name: "At most one response",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A request gets at most one response.",
    source: source::DERIVED,
    applies_to: "responses over time",
    why: "The client has already completed the request. The client treats the second response as an error \
          or matches it to a new request with the same id.",
    example: r#"→ {"$fw.version":"1.0","id":"c1","body":{"type":"SYS-PING"}}
← {"$fw.version":"1.0","id":"s1","refs":"c1","body":{"type":"ACK-ACK"}}
← {"$fw.version":"1.0","id":"s2","refs":"c1","body":{"type":"ACK-ACK"}}"#,
    fix: "Send one response per request. Report later results with ASYNC-RESP and a receipt.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("SYS-PING is answered twice.", |out| {
    if out.request_type() == Some("SYS-PING") {
        let refs = out.message()["refs"].as_str().unwrap_or_default().to_owned();
        out.follow(Some(&refs), json!({ "type": "ACK-ACK" }));
    }
}))
.mutants(&[Mutant::session("a second response", |session| {
    session.answers("ask-2", json!({ "body": { "type": "ACK-ACK" } }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !reply::refers(exchange) {
        return;
    }
    context.covered();
    if exchange.reference == Reference::Answered {
        exchange.violates(context, || {
            let refs = exchange.refs.map(body::quoted).unwrap_or_default();
            Detail::new(format!("the request {refs} was already answered")).at("/refs")
        });
    }
}
