//! `FW-SYS-VER-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-VER-01",
    name: "Name of the software",
    level: Level::Must,
    status: Status::Normative,
    statement: "`software` is a string.",
    source: source::MESSAGES,
    applies_to: "SYS-VER",
    why: "Clients show the name and use it to enable workarounds. Without the name, clients cannot \
          identify the server.",
    example: r#"{"type":"SYS-VER","software":7,"version":"1.0"}"#,
    fix: "Send the name of the server software as a string.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-VER"], "software", attribution::MISSING)])
.bug(Bug::message("The `software` of SYS-VER is a number.", |out| out.set("SYS-VER", "software", json!(7))))
.mutants(&[
    Mutant::reply("`software` is a number", "SYS-VER", |body| body["software"] = 7.into()),
    Mutant::reply("missing `software`", "SYS-VER", |body| mutant::remove(body, "software")),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-VER").is_some() {
        body::field(message, context, "software", true, &ExpectedValue::Text);
    }
}
