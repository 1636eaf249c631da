//! `FW-ASY-09`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-09",
    name: "Receipts stay on their connection",
    level: Level::Info,
    status: Status::Advisory,
    statement: "ASYNC-RESP, ASYNC-ST and ASYNC-TIMEOUT contain only receipts that were issued on the same \
                connection.",
    source: source::DERIVED,
    applies_to: "ASYNC-* over time",
    why: "The client does not recognize the receipt and drops the notification. If the receipt belongs \
          to another client, that client never gets its result.",
    example: r#"(no response on this connection contained the receipt r99)
← {"type":"ASYNC-RESP","id":"r99","result":true}"#,
    fix: "Remember which connection started each operation, and send the operation's notifications only \
          on that connection.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("A progress notification has a receipt that was never issued.", |out| {
    if out.receipt().is_some() {
        out.follow(None, bug::progress(&json!("nobody-has-this")));
    }
}))
.mutants(&[Mutant::session("the end of an operation that never began", |session| {
    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.role != Role::Notification {
        return;
    }
    for named in
        exchange.operations.iter().filter(|named| named.is_known && exchange.record.connection.is_ordered)
    {
        context.covered();
        if matches!(named.stage(), None | Some(Stage::Early)) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "no response on this connection contained the receipt {}",
                    body::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
