//! `FW-SYS-PING-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-PING-02",
    name: "No SYS-PING in return",
    level: Level::Should,
    status: Status::Normative,
    statement: "SYS-PING is not answered with SYS-PING.",
    source: source::MESSAGES,
    applies_to: "SYS-PING",
    why: "Either side may send SYS-PING as a request. A client that mistakes a SYS-PING response for a \
          request and answers it may start an endless exchange.",
    example: r#"→ {"type":"SYS-PING"}
← {"type":"SYS-PING"}"#,
    fix: "Answer with ACK-ACK instead of copying the type of the request.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("SYS-PING is answered with SYS-PING.", |out| {
    if out.request_type() == Some("SYS-PING") {
        out.message()["body"] = json!({ "type": "SYS-PING" });
    }
}))
.mutants(&[Mutant::reply("a SYS-PING response", "ACK-ACK", |body| body["type"] = "SYS-PING".into())]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let request = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
    if exchange.role != Role::Response || !exchange.is_from_server() || request != Some("SYS-PING") {
        return;
    }
    context.covered();
    if exchange.type_name == Some("SYS-PING") {
        exchange.violates(context, || Detail::new("SYS-PING is a request, not a response").at("/body/type"));
    }
}
