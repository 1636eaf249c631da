//! `FW-ASY-12`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-12",
    name: "Fields of ASYNC-ST",
    level: Level::Must,
    status: Status::Normative,
    statement: "ASYNC-ST has `id` and `progress`. `percentage` is an integer from 0 to 100, or null, and \
                `suspended` is a boolean.",
    source: source::ASYNC,
    applies_to: "ASYNC-ST",
    why: "Clients draw a progress bar from `percentage` and ask the user for input if `suspended` is \
          true. Wrong values break both features.",
    example: r#"{"type":"ASYNC-ST","id":"r1","progress":{"percentage":110}}"#,
    fix: "Send `id` and `progress` in every ASYNC-ST. Round and clamp the percentage to 0–100, or send \
          null if it is unknown.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["ASYNC-ST"], "id", attribution::MISSING),
    Attribution::new(&["ASYNC-ST"], "progress", attribution::MISSING),
    Attribution::new(&["ASYNC-ST"], "progress.percentage", attribution::WRONG),
    Attribution::new(&["ASYNC-ST"], "suspended", &[Fault::Kind]),
])
.bug(Bug::message("The percentage in ASYNC-ST is 140.", |out| {
    if let Some(body) = out.body_of("ASYNC-ST") {
        body["progress"]["percentage"] = json!(140);
    }
}))
.mutants(&[
    Mutant::notice("110 percent", "ASYNC-ST", |body| body["progress"]["percentage"] = 110.into()),
    Mutant::notice("missing `progress`", "ASYNC-ST", |body| mutant::remove(body, "progress")),
    Mutant::notice("`suspended` is a string", "ASYNC-ST", |body| body["suspended"] = "no".into()),
]);

const PERCENTAGE: ExpectedValue = ExpectedValue::Nullable(&ExpectedValue::Integer(0, 100));

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-ST").is_none() {
        return;
    }
    body::field(message, context, "id", true, &ExpectedValue::Text);
    body::field(message, context, "progress", true, &ExpectedValue::Object);
    body::field(message, context, "suspended", false, &ExpectedValue::Nullable(&ExpectedValue::Bool));
    let keys = ["body", "progress"];
    body::member(message, context, message.field("progress"), &keys, ("percentage", false), &PERCENTAGE);
}
