//! `FW-SYS-TIME-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-TIME-01",
    name: "Type of the server time",
    level: Level::Must,
    status: Status::Normative,
    statement: "`timestamp` is a number of milliseconds.",
    source: source::MESSAGES,
    applies_to: "SYS-TIME",
    why: "Clients compute the clock offset from the timestamp. If the timestamp is in seconds, the offset \
          is wrong by decades.",
    example: r#"{"type":"SYS-TIME","timestamp":"12:30:00"}"#,
    fix: "Send the Unix time in milliseconds as an integer.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-TIME"], "timestamp", attribution::MISSING)])
.bug(Bug::message("The server time is a string.", |out| out.set("SYS-TIME", "timestamp", json!("noon"))))
.mutants(&[
    Mutant::reply("a missing timestamp", "SYS-TIME", |body| mutant::remove(body, "timestamp")),
    Mutant::reply("a string", "SYS-TIME", |body| body["timestamp"] = "noon".into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-TIME").is_some() {
        body::field(message, context, "timestamp", true, &ExpectedValue::Number);
    }
}
