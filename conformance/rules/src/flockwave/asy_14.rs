//! `FW-ASY-14`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-14",
    name: "No result while suspended",
    level: Level::Must,
    status: Status::Normative,
    statement: "A suspended operation has no result before the client resumes or cancels it. The \
                operation may fail, or the server may abandon it with ASYNC-TIMEOUT.",
    source: source::ASYNC,
    applies_to: "ASYNC-* over time",
    why: "A suspended operation waits for a decision, such as a confirmation by the operator. If it ends \
          on its own, the UAV may act without that decision.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r1"}}
← {"type":"ASYNC-ST","id":"r1","progress":{},"suspended":true}
← {"type":"ASYNC-RESP","id":"r1","result":true}"#,
    fix: "Keep the operation suspended until ASYNC-RESUME or ASYNC-CANCEL names its receipt, or until the \
          client disconnects.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("Suspended operations resume on their own."))
.mutants(&[Mutant::session("a suspended operation that ends on its own", |session| {
    session
        .exchange(json!({ "type": "UAV-RTH", "ids": ["kite"] }), json!({ "receipt": { "kite": "rcpt-8" } }));
    session.notify(json!({ "type": "ASYNC-ST", "id": "rcpt-8", "progress": {}, "suspended": true }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    // A suspended operation may fail, for example because its UAV is lost.
    if exchange.notification("ASYNC-RESP").is_none() || body::is_present(exchange.field("error")) {
        return;
    }
    for named in exchange.operations.iter().filter(|_| exchange.record.connection.is_ordered) {
        let Some(operation) = &named.before else { continue };
        context.covered();
        if operation.stage == Stage::Suspended {
            exchange.violates(context, || {
                Detail::new(format!(
                    "{} ended while suspended: the client neither resumed nor cancelled it",
                    body::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
