//! `FW-ENV-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-03",
    name: "Message id is a string",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `id` of a message is a string.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "Clients use the id to detect duplicate messages and to refer to a message in a log. A strict \
          client rejects a message without a valid id.",
    example: r#"{"$fw.version":"1.0","id":7,"body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Add an `id` to every message, including notifications. Convert numeric ids to strings.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Message ids are numbers.", |out| {
    let number = out.number;
    out.message()["id"] = json!(number);
}))
.mutants(&[
    Mutant::reply_message("an id that is a number", "SYS-VER", |message| message["id"] = 7.into()),
    Mutant::reply_message("a missing id", "SYS-VER", |message| mutant::remove(message, "id")),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::member(message, context, Some(message.value), &[], ("id", true), &ExpectedValue::Text);
}
