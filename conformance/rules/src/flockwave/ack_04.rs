//! `FW-ACK-04`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ACK-04",
    name: "Fields of ACK-NAK",
    level: Level::Must,
    status: Status::Normative,
    statement: "The body of ACK-NAK has no fields other than `type` and an optional string `reason`.",
    source: source::MESSAGES,
    applies_to: "ACK-NAK",
    why: "Clients show `reason` to the operator. If `reason` is not a string, the message may fail to \
          decode, and the operator does not learn why the request was refused.",
    example: r#"{"type":"ACK-NAK","reason":{"en":"Not allowed"}}"#,
    fix: "Send `reason` as one human-readable string, or omit it. Remove all other fields.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["ACK-NAK"], "*", &[Fault::Additional]),
    Attribution::new(&["ACK-NAK"], "reason", &[Fault::Kind]),
])
.bug(Bug::message("The `reason` of ACK-NAK is an object.", |out| {
    out.set("ACK-NAK", "reason", json!({ "en": "no" }));
}))
.mutants(&[
    Mutant::reply("a reason that is a number", "ACK-NAK", |body| body["reason"] = 7.into()),
    Mutant::reply("an additional field", "ACK-NAK", |body| body["code"] = 7.into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = message.body_of("ACK-NAK") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type" && key != "reason") {
        message.violates(context, || {
            Detail::new(format!("unexpected field {}", body::quoted(key))).at(pointer(&["body", key]))
        });
    }
    body::field(message, context, "reason", false, &ExpectedValue::Nullable(&ExpectedValue::Text));
}
