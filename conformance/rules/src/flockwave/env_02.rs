//! `FW-ENV-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-02",
    name: "Version is a string",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `$fw.version` of a message is a string.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "This field identifies a Flockwave message. A client that requires a string rejects the whole \
          message.",
    example: r#"{"$fw.version":1,"id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Add `\"$fw.version\":\"1.0\"` to every message. Write the version as a string, not as a number.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("The protocol version is a number.", |out| out.message()["$fw.version"] = json!(1)))
.mutants(&[
    Mutant::reply_message("a missing version", "SYS-VER", |message| {
        mutant::remove(message, "$fw.version");
    }),
    Mutant::reply_message("a version that is a number", "SYS-VER", |message| {
        message["$fw.version"] = 1.into();
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::member(message, context, Some(message.value), &[], ("$fw.version", true), &ExpectedValue::Text);
}
