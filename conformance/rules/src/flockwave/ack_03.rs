//! `FW-ACK-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ACK-03",
    name: "Fields of ACK-ACK",
    level: Level::Must,
    status: Status::Normative,
    statement: "The body of ACK-ACK has no fields other than `type`.",
    source: source::MESSAGES,
    applies_to: "ACK-ACK",
    why: "The definition allows no additional fields in this object, so a strict client rejects the \
          message. A successful request then looks like a failure.",
    example: r#"{"type":"ACK-ACK","reason":"Done"}"#,
    fix: "Send only `type`. To return a result, answer with the message type of the request instead.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["ACK-ACK"], "*", &[Fault::Additional])])
.bug(Bug::message("ACK-ACK has a `reason`.", |out| out.set("ACK-ACK", "reason", json!("why not"))))
.mutants(&[Mutant::reply("an ACK-ACK with a reason", "ACK-ACK", |body| body["reason"] = "Fine".into())]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = message.body_of("ACK-ACK") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type") {
        message.violates(context, || {
            Detail::new(format!("unexpected field {}", body::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
