//! `FW-ASY-09`.

use serde_json::json;

use super::fw::{self, Role, Stage, Turn};
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
        make: || fw::then(|talk| talk.tells(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }))),
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.role != Role::Notification {
        return;
    }
    for named in turn.operations.iter().filter(|named| named.is_known && turn.exchange.connection.is_told) {
        context.covered();
        if matches!(named.stage(), None | Some(Stage::Early)) {
            turn.breaks(context, || {
                Detail::new(format!(
                    "no reply on this connection has had the receipt {}",
                    fw::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
