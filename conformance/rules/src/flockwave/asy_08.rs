//! `FW-ASY-08`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-08",
    name: "Types in ASYNC-RESP",
    level: Level::Must,
    status: Status::Normative,
    statement: "In ASYNC-RESP, `id` is a string and `error`, if present, is a string.",
    source: source::ASYNC,
    applies_to: "ASYNC-RESP",
    why: "If `id` is not a string, the client cannot find the operation. If `error` is not a string, the \
          client cannot show the reason for the failure.",
    example: r#"{"type":"ASYNC-RESP","id":"r1","error":7}"#,
    fix: "Copy the receipt to `id` unchanged. Send `error` as one human-readable string.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["ASYNC-RESP"], "id", attribution::MISSING),
    Attribution::new(&["ASYNC-RESP"], "error", &[Fault::Kind]),
])
.bug(Bug::message("The `error` of ASYNC-RESP is a number.", |out| {
    if let Some(body) = out.body_of("ASYNC-RESP").and_then(Value::as_object_mut) {
        body.remove("result");
        body.insert("error".to_owned(), json!(7));
    }
}))
.mutants(&[
    Mutant::notice("an id that is a number", "ASYNC-RESP", |body| body["id"] = 7.into()),
    Mutant::notice("an error that is a number", "ASYNC-RESP", |body| {
        *body = json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "error": 7 });
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-RESP").is_some() {
        body::field(message, context, "id", true, &ExpectedValue::Text);
        body::field(message, context, "error", false, &ExpectedValue::Nullable(&ExpectedValue::Text));
    }
}
