//! `FW-ASY-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-01",
    name: "Response about one object",
    level: Level::Must,
    status: Status::Normative,
    statement: "A response about one object has exactly one of `result`, `error` and `receipt`.",
    source: source::ASYNC,
    applies_to: "LOG-DATA",
    why: "If two of the fields are present, the client does not know whether the operation succeeded, \
          failed or is still pending. If none is present, the client waits forever.",
    example: r#"{"type":"LOG-DATA","receipt":"r4","error":"The log is not available yet"}"#,
    fix: "Send `result` after success, `error` after failure, and `receipt` only while the operation is \
          pending.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("LOG-DATA has both a receipt and an error.", |out| {
    if let Some(body) = out.body_of("LOG-DATA")
        && body.get("receipt").is_some()
    {
        body["error"] = json!("the log is late");
    }
}))
.mutants(&[
    Mutant::reply("a result in addition to the receipt", "LOG-DATA", |body| {
        body["result"] = json!({ "id": "7", "kind": "text", "body": "Took off" });
    }),
    Mutant::session("no result, error or receipt", |session| {
        session.exchange(json!({ "type": "LOG-DATA", "uavId": "kite", "logId": "8" }), json!({}));
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.response("LOG-DATA").is_some() {
        body::exactly_one(message, context, &["result", "error", "receipt"], "result");
    }
}
