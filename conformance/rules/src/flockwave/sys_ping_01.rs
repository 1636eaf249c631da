//! `FW-SYS-PING-01`.
//!
//! Before login, a server may refuse even SYS-PING with ACK-NAK. An ACK-NAK is therefore a violation only if a probe
//! sent the request, because a probe logs in first.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-PING-01",
    name: "Response to SYS-PING",
    level: Level::Must,
    status: Status::Normative,
    statement: "SYS-PING is answered with ACK-ACK.",
    source: source::MESSAGES,
    applies_to: "SYS-PING",
    why: "Clients ping to check that the server is alive. After any other response, clients report the \
          connection as lost and reconnect.",
    example: r#"→ {"type":"SYS-PING"}
← {"type":"SYS-PONG"}"#,
    fix: "Answer every SYS-PING with ACK-ACK, regardless of the server's state.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("SYS-PING is answered with ACK-NAK.", |out| {
    if out.request_type() == Some("SYS-PING") {
        out.message()["body"] = json!({ "type": "ACK-NAK" });
    }
}))
.mutants(&[
    Mutant::refused("SYS-PING is refused", "tcp#9"),
    Mutant::unanswered("SYS-PING is not answered", "tcp#9"),
    Mutant::reply("SYS-PING is answered with a different type", "ACK-ACK", |body| {
        *body = json!({ "type": "CONN-LIST", "ids": [] });
    }),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_trial = exchange.tried(&RULE.rule).is_some();
    if is_trial && !served::served(exchange, context) {
        return;
    }
    let request = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
    if exchange.role != Role::Response || !exchange.is_from_server() || request != Some("SYS-PING") {
        return;
    }
    if !is_trial {
        context.covered();
    }
    // FW-SYS-PING-02 reports a SYS-PING.
    if let Some(found) =
        exchange.type_name.filter(|found| !["ACK-ACK", "ACK-NAK", "SYS-PING"].contains(found))
    {
        exchange.violates(context, || Detail::differs("ACK-ACK", body::quoted(found)).at("/body/type"));
    }
}
