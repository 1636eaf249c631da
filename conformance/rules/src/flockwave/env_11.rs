//! `FW-ENV-11`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-11",
    name: "Body or error is required",
    level: Level::Should,
    status: Status::Disputed(
        "In the specification text, `body` is an object; the published JSON Schema also allows null. This \
         rule requires an object.",
    ),
    statement: "A message has either a `body` that is an object or an `error`.",
    source: source::SCHEMA,
    applies_to: "messages from the server",
    why: "Without a body, the client cannot determine the type of the message and drops the message.",
    example: r#"{"$fw.version":"1.0","id":"s1","refs":"c1","body":"ok"}"#,
    fix: "Send an object with at least a `type` field as the `body`. Use ACK-ACK if there is no result.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("UAV-INF notifications have neither `body` nor `error`.", |out| {
    if out.notification_of("UAV-INF").is_some()
        && let Some(message) = out.message().as_object_mut()
    {
        message.remove("body");
    }
}))
.mutants(&[
    Mutant::reply_message("neither `body` nor `error`", "ACK-ACK", |message| {
        mutant::remove(message, "body");
    }),
    Mutant::reply_message("a body that is a string", "ACK-ACK", |message| {
        message["body"] = "fine".into();
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    match message.value.get("body") {
        Some(Tree::Object(_)) => {}
        None | Some(Tree::Null) if body::is_present(message.value.get("error")) => {}
        None => message.violates(context, || Detail::differs("`body` or `error`", "neither")),
        Some(other) => message.violates(context, || Detail::differs("an object", other).at("/body")),
    }
}
