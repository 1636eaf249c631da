//! `FW-ASY-11`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-11",
    name: "No progress after the end",
    level: Level::Info,
    status: Status::Advisory,
    statement: "No ASYNC-ST is sent for a receipt that has ended.",
    source: source::DERIVED,
    applies_to: "ASYNC-ST over time",
    why: "The client has already closed the operation. The client drops the notification, or shows the \
          finished operation as running again.",
    example: r#"→ {"type":"UAV-RTH","ids":["uav-1"]}
← {"type":"UAV-RTH","receipt":{"uav-1":"r1"}}
← {"type":"ASYNC-RESP","id":"r1","result":true}
← {"type":"ASYNC-ST","id":"r1","progress":{"percentage":80}}"#,
    fix: "Send the queued progress notifications before ASYNC-RESP or ASYNC-TIMEOUT, or discard them.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("A progress notification follows ASYNC-RESP.", |out| {
    if let Some(body) = out.body_of("ASYNC-RESP") {
        let receipt = body["id"].clone();
        out.follow(None, bug::progress(&receipt));
    }
}))
.mutants(&[Mutant::session("progress after the end", |session| {
    let late = json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": { "percentage": 80 } });
    session.notify(late);
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.notification("ASYNC-ST").is_none() {
        return;
    }
    for named in exchange.operations.iter().filter(|_| exchange.record.connection.is_ordered) {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.violates(context, || {
                Detail::new(format!("{} has already ended", body::quoted(&named.receipt))).at("/body/id")
            });
        }
    }
}
