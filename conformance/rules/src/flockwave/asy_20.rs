//! `FW-ASY-20`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-20",
    name: "Fields of ASYNC-TIMEOUT",
    level: Level::Must,
    status: Status::Normative,
    statement: "ASYNC-TIMEOUT has `ids`, a list of strings.",
    source: source::ASYNC,
    applies_to: "ASYNC-TIMEOUT",
    why: "The client does not know which operations timed out and keeps waiting for them.",
    example: r#"{"type":"ASYNC-TIMEOUT","ids":"r2"}"#,
    fix: "Send the receipts as a list of strings in `ids`, even if there is only one receipt.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["ASYNC-TIMEOUT"], "ids", attribution::MISSING),
    Attribution::new(&["ASYNC-TIMEOUT"], "ids.*", attribution::MISSING),
])
.bug(Bug::message("The `ids` of ASYNC-TIMEOUT is a string.", |out| {
    if let Some(body) = out.body_of("ASYNC-TIMEOUT") {
        body["ids"] = body["ids"][0].take();
    }
}))
.mutants(&[Mutant::notice("a single id instead of a list", "ASYNC-TIMEOUT", |body| {
    body["ids"] = "rcpt-2".into();
})]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-TIMEOUT").is_some() {
        body::field(message, context, "ids", true, &ExpectedValue::List(&ExpectedValue::Text));
    }
}
