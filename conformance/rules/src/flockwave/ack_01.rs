//! `FW-ACK-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ACK-01",
    name: "Acknowledgments are responses",
    level: Level::Must,
    status: Status::Normative,
    statement: "ACK-ACK and ACK-NAK are sent only as responses.",
    source: source::MESSAGES,
    applies_to: "ACK-ACK, ACK-NAK",
    why: "Without `refs`, a client cannot match an acknowledgment to its request, so the request times out.",
    example: r#"{"$fw.version":"1.0","id":"s7","body":{"type":"ACK-ACK"}}"#,
    fix: "Copy the `id` of the request to the `refs` of the acknowledgment. Do not send ACK-ACK or \
          ACK-NAK without a request.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("An ACK-ACK without `refs` follows each SYS-VER response.", |out| {
    if out.kind() == "SYS-VER" {
        out.follow(None, json!({ "type": "ACK-ACK" }));
    }
}))
.mutants(&[Mutant::session("an ACK-ACK without `refs`", |session| {
    session.notify(json!({ "type": "ACK-ACK" }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !exchange.is_from_server() || !matches!(exchange.type_name, Some("ACK-ACK" | "ACK-NAK")) {
        return;
    }
    // A server has no id to refer to if it refuses a message without an id.
    if exchange.role != Role::Response && exchange.may_answer_unknown {
        return;
    }
    context.covered();
    // FW-ENV-26 reports null.
    if exchange.role != Role::Response && exchange.message().is_some_and(|value| value.get("refs").is_none())
    {
        exchange.violates(context, || Detail::new("an acknowledgment without `refs`"));
    }
}
