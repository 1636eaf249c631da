//! `FW-ASY-06`.

use super::asy_09;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-06",
    name: "Receipt before its notifications",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A response that contains a receipt precedes all notifications about that receipt.",
    source: source::DERIVED,
    applies_to: "ASYNC-* over time",
    why: "The client hasn't received the receipt yet and drops the notification. The client then waits \
          for a result that was already sent.",
    example: r#"→ {"type":"UAV-RTH","ids":["uav-1"]}
← {"type":"ASYNC-RESP","id":"r8","result":true}
← {"type":"UAV-RTH","receipt":{"uav-1":"r8"}}"#,
    fix: "Send the response before you start the operation, or hold back the operation's notifications \
          until the response is sent.",
})
.checks(&[Check::Exchange(check)])
.bug(
    Bug::message("A progress notification precedes the response that contains its receipt.", |out| {
        if let Some(receipt) = out.receipt() {
            out.precede(bug::progress(&receipt));
        }
    })
    .also(&[&asy_09::RULE.rule]),
)
.mutants(&[Mutant::session("an operation that ends before its receipt is sent", |session| {
    let id = session.sends(json!({ "type": "UAV-RTH", "ids": ["kite"] }));
    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }));
    session.answers(&id, json!({ "body": { "type": "UAV-RTH", "receipt": { "kite": "rcpt-8" } } }));
})
.also(&[&asy_09::RULE.rule])]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for named in exchange.opened.iter().filter(|named| named.is_known) {
        context.covered();
        if named.stage() == Some(Stage::Early) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "an earlier notification already contained {}",
                    body::quoted(&named.receipt)
                ))
                .at("/body/receipt")
            });
        }
    }
}
