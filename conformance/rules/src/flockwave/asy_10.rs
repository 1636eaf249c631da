//! `FW-ASY-10`.
//!
//! The specification sets no time limit, so a missing end doesn't violate this rule. `FW-ASY-10I` reports it.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-10",
    name: "Each operation ends once",
    level: Level::Must,
    status: Status::Normative,
    statement: "Exactly one ASYNC-RESP or ASYNC-TIMEOUT is sent for each receipt.",
    source: source::ASYNC,
    applies_to: "ASYNC-* over time",
    why: "After two final messages, the client and the server may disagree about the result.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r2"}}
← {"type":"ASYNC-TIMEOUT","ids":["r2"]}
← {"type":"ASYNC-RESP","id":"r2","result":true}"#,
    fix: "Send one ASYNC-RESP or ASYNC-TIMEOUT for each receipt and then delete the receipt. Discard any \
          later result.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("Each ASYNC-RESP is sent twice.", |out| {
    if let Some(body) = out.body_of("ASYNC-RESP") {
        let body = body.clone();
        out.follow(None, body);
    }
}))
.mutants(&[
    Mutant::session("a result after the timeout", |session| {
        session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-2", "result": "Flaps out" }));
    }),
    Mutant::session("a second result", |session| {
        session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "result": true }));
    }),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served::tried(exchange, context);
    let is_end = exchange.notification("ASYNC-RESP").or(exchange.notification("ASYNC-TIMEOUT")).is_some();
    if !is_end || !exchange.record.connection.is_ordered {
        return;
    }
    for named in &exchange.operations {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.violates(context, || {
                Detail::new(format!("{} has already ended", body::quoted(&named.receipt))).at("/body")
            });
        }
    }
}
