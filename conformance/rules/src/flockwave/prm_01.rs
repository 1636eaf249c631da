//! `FW-PRM-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-PRM-01",
    name: "Success without failed parameters",
    level: Level::Must,
    status: Status::Normative,
    statement: "If `success` is true, `failed` is empty or absent.",
    source: source::MESSAGES,
    applies_to: "results of PRM-SET-MANY",
    why: "The client reports that all parameters were set, so the operator flies without noticing that \
          some still have their old values.",
    example: r#"{"type":"PRM-SET-MANY","result":{"uav-1":{"success":true,"failed":["CRUISE_SPEED"]}}}"#,
    fix: "Set `success` to true only if all parameters were set. Otherwise, set it to false and list the \
          parameters that were not set in `failed`.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("PRM-SET-MANY reports success but lists failed parameters.", |out| {
    let Some(body) = out.body_of("PRM-SET-MANY") else { return };
    for outcome in body["result"].as_object_mut().into_iter().flat_map(|map| map.values_mut()) {
        *outcome = json!({ "success": true, "failed": ["CRUISE_SPEED"] });
    }
}))
.mutants(&[
    Mutant::reply("success with a failed parameter", "PRM-SET-MANY", |body| {
        body["result"]["kite"]["success"] = true.into();
    }),
    Mutant::session("success with a failed parameter in ASYNC-RESP", |session| {
        let request = json!({ "type": "PRM-SET-MANY", "ids": ["kite"], "parameters": { "GEAR": 1 } });
        let outcome = json!({ "success": true, "failed": ["GEAR"] });
        session.exchange(request, json!({ "receipt": { "kite": "rcpt-8" } }));
        session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": outcome }));
    }),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let immediate =
        body::members(exchange.body, "result").iter().filter(|_| exchange.response("PRM-SET-MANY").is_some());
    for (key, outcome) in immediate {
        check_outcome(exchange, context, outcome, &["body", "result", key]);
    }
    let later = exchange.notification("ASYNC-RESP").and_then(|body| body.get("result"));
    let known = exchange.operations.first().and_then(|named| named.before.as_ref());
    if let Some(outcome) =
        later.filter(|_| known.is_some_and(|known| known.type_name.as_deref() == Some("PRM-SET-MANY")))
    {
        check_outcome(exchange, context, outcome, &["body", "result"]);
    }
}

fn check_outcome(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, outcome: &Tree<'_>, keys: &[&str]) {
    context.covered();
    let is_success = outcome.get("success") == Some(&Tree::Bool(true));
    let failed = if let Some(Tree::List(failed)) = outcome.get("failed") { failed.len() } else { 0 };
    if is_success && failed > 0 {
        exchange.violates(context, || {
            Detail::new(format!("`success` is true, but `failed` lists {failed} parameters"))
                .at(pointer(keys))
        });
    }
}
