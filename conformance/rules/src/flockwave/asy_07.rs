//! `FW-ASY-07`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-07",
    name: "Result or error in ASYNC-RESP",
    level: Level::Must,
    status: Status::Normative,
    statement: "ASYNC-RESP has exactly one of `result` and `error`.",
    source: source::ASYNC,
    applies_to: "ASYNC-RESP",
    why: "If both or neither are present, the client does not know whether the operation succeeded.",
    example: r#"{"type":"ASYNC-RESP","id":"r1","result":true,"error":"Motor fault"}"#,
    fix: "Send `result` after success and `error` after failure, never both. Send `result` even if it is \
          null.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("ASYNC-RESP has both a result and an error.", |out| {
    if let Some(body) = out.body_of("ASYNC-RESP") {
        body["result"] = json!(true);
        body["error"] = json!("and yet");
    }
}))
.mutants(&[
    Mutant::notice("both a result and an error", "ASYNC-RESP", |body| {
        body["error"] = "Winch broke".into();
    }),
    Mutant::notice("neither a result nor an error", "ASYNC-RESP", |body| mutant::remove(body, "result")),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-RESP").is_some() {
        body::exactly_one(message, context, &["result", "error"], "result");
    }
}
