//! `FW-ENV-14`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-14",
    name: "Body type is a string",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `type` of a body is a string.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "Clients choose the handler for a message by its type. Without a valid type, clients drop the \
          message.",
    example: r#"{"$fw.version":"1.0","id":"s1","body":{"type":7}}"#,
    fix: "Add the message type as a string to every body, such as `\"type\":\"UAV-INF\"`.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("The `type` of UAV-INF notifications is a number.", |out| {
    if let Some(body) = out.notification_of("UAV-INF") {
        body["type"] = json!(7);
    }
}))
.mutants(&[
    Mutant::reply_message("a missing type", "ACK-ACK", |message| message["body"] = json!({})),
    Mutant::reply("a type that is a number", "ACK-ACK", |body| body["type"] = 7.into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body.is_some() {
        body::field(message, context, "type", true, &ExpectedValue::Text);
    }
}
