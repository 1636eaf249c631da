//! `FW-SYS-VER-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-VER-03",
    name: "Optional strings in SYS-VER",
    level: Level::Must,
    status: Status::Normative,
    statement: "`name` and `revision`, if present, are strings.",
    source: source::MESSAGES,
    applies_to: "SYS-VER",
    why: "Clients show the name to distinguish servers. If the name is not a string, the message may fail \
          to decode.",
    example: r#"{"type":"SYS-VER","software":"Example","version":"1.0","revision":7}"#,
    fix: "Convert `name` and `revision` to strings, or omit them.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["SYS-VER"], "name", &[Fault::Kind]),
    Attribution::new(&["SYS-VER"], "revision", &[Fault::Kind]),
])
.bug(Bug::message("The `name` of SYS-VER is a list.", |out| out.set("SYS-VER", "name", json!(["glider"]))))
.mutants(&[
    Mutant::reply("a revision that is a number", "SYS-VER", |body| body["revision"] = 7.into()),
    Mutant::reply("a name that is a list", "SYS-VER", |body| body["name"] = json!([])),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-VER").is_some() {
        body::field(message, context, "name", false, &ExpectedValue::Nullable(&ExpectedValue::Text));
        body::field(message, context, "revision", false, &ExpectedValue::Nullable(&ExpectedValue::Text));
    }
}
