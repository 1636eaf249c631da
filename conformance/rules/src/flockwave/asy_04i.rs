//! `FW-ASY-04I`.

use super::asy_10;
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-04I",
    name: "Unique pending receipts",
    level: Level::Info,
    status: Status::Advisory,
    statement: "No two pending operations on a connection have the same receipt.",
    source: source::DERIVED,
    applies_to: "all responses with `receipt` on a connection",
    why: "When a notification with a shared receipt arrives, the client does not know which operation the \
          notification belongs to.",
    example: r#"→ {"type":"UAV-RTH","ids":["uav-1","uav-2"]}
← {"type":"UAV-RTH","receipt":{"uav-1":"r8","uav-2":"r8"}}"#,
    fix: "Create a new receipt for each object and each request. Do not reuse a receipt before its \
          operation has ended.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::behaviour("All operations have the same receipt.").also(&[&asy_10::RULE.rule]))
.mutants(&[Mutant::session("two UAVs with the same receipt", |session| {
    let same = json!({ "receipt": { "kite": "rcpt-8", "swift": "rcpt-8" } });
    let request = json!({ "type": "UAV-RTH", "ids": ["kite", "swift"] });
    session.exchange(request, same);
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for named in exchange.opened.iter().filter(|named| named.is_known) {
        context.covered();
        if matches!(named.stage(), Some(Stage::Open | Stage::Suspended | Stage::Released)) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "{} is already the receipt of another pending operation",
                    body::quoted(&named.receipt)
                ))
                .at("/body/receipt")
            });
        }
    }
}
