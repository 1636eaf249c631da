//! `FW-ASY-09`.

use serde_json::json;

use super::fw::{self, Exchange, Role, Stage};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-09",
        level: Level::Info,
        status: Status::Advisory,
        statement: "ASYNC-RESP, ASYNC-ST and ASYNC-TIMEOUT name receipts that were given on the same connection.",
        source: fw::DERIVED,
        applies_to: "ASYNC-* over time",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "the end of what never began",
        make: || {
            fw::then(|session| session.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true })))
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.role != Role::Notification {
        return;
    }
    for named in
        exchange.operations.iter().filter(|named| named.is_known && exchange.record.connection.is_told)
    {
        context.covered();
        if matches!(named.stage(), None | Some(Stage::Early)) {
            exchange.breaks(context, || {
                Detail::new(format!(
                    "no reply on this connection has had the receipt {}",
                    fw::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
