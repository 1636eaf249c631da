//! `FW-ASY-16`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-16",
    name: "Complete answer to a cancel or resume request",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Each receipt in an ASYNC-CANCEL or ASYNC-RESUME request is in exactly one of `success` \
                and `error` of the response.",
    source: source::DERIVED,
    applies_to: "ASYNC-CANCEL, ASYNC-RESUME",
    why: "The client does not know whether the operation was cancelled or resumed.",
    example: r#"→ {"type":"ASYNC-CANCEL","ids":["r1","r2"]}
← {"type":"ASYNC-CANCEL","success":["r1"]}"#,
    fix: "Add every receipt of the request to either `success` or `error`, including unknown receipts.",
})
.checks(&[Check::Exchange(|exchange, context| {
    reply::partition(exchange, context, &["ASYNC-CANCEL", "ASYNC-RESUME"]);
})])
.bug(Bug::message("Receipts in `success` are also in `error`.", |out| {
    if !["ASYNC-CANCEL", "ASYNC-RESUME"].contains(&out.kind()) {
        return;
    }
    let body = &mut out.message()["body"];
    if let Some(receipt) = body["success"][0].as_str().map(str::to_owned) {
        body["error"][receipt] = json!("and yet");
    }
}))
.mutants(&[
    Mutant::reply("a receipt in both `success` and `error`", "ASYNC-RESUME", |body| {
        body["error"]["rcpt-1"] = "Not now".into();
    }),
    Mutant::reply("a receipt in neither `success` nor `error`", "ASYNC-RESUME", |body| {
        mutant::remove(body, "error");
    }),
]);
