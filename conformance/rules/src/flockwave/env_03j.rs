//! `FW-ENV-03J`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-03J",
    name: "Length of a message id",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `id` of a message is 1 to 36 characters long.",
    source: source::SCHEMA,
    applies_to: "messages from the server",
    why: "The JSON Schema allows no other length, so clients that validate messages reject the message.",
    example: r#"{"$fw.version":"1.0","id":"","body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Use a UUID (36 characters) or a counter as the id.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Message ids are 40 characters long.", |out| {
    let id = format!("{:0>40}", out.number);
    out.message()["id"] = json!(id);
}))
.mutants(&[
    Mutant::reply_message("an id of 37 characters", "SYS-VER", |message| {
        message["id"] = "x".repeat(37).into();
    }),
    Mutant::reply_message("an empty id", "SYS-VER", |message| message["id"] = "".into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.id.is_none() {
        return;
    }
    body::member(message, context, Some(message.value), &[], ("id", true), &ExpectedValue::Length(1, 36));
}
