//! `FW-ACK-01`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Role, Rule, RuleContext, Status, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ACK-01",
        name: "Acknowledgments are responses",
        level: Level::Must,
        status: Status::Normative,
        statement: "ACK-ACK and ACK-NAK are sent only as responses.",
        source: source::MESSAGES,
        applies_to: "ACK-ACK, ACK-NAK",
        why: "Without `refs`, a client cannot match an acknowledgment to its request, so the request times out.",
        example: r#"{"$fw.version":"1.0","id":"s7","body":{"type":"ACK-ACK"}}"#,
        fix: "Copy the `id` of the request to the `refs` of the acknowledgment. Do not send ACK-ACK or ACK-NAK \
              without a request.",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("An ACK-ACK without `refs` follows each SYS-VER response.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "ACK-ACK" }));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "an ACK-ACK without `refs`",
        make: || mutant::then(|session| session.notify(json!({ "type": "ACK-ACK" }))),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if !matches!(message.type_name, Some("ACK-ACK" | "ACK-NAK")) {
        return;
    }
    context.covered();
    // FW-ENV-26 reports null.
    if message.role != Role::Response && message.value.get("refs").is_none() {
        message.violates(context, || Detail::new("an acknowledgment without `refs`"));
    }
}
