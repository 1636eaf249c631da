//! `FW-ASY-09`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Stage, Status, body,
    bug, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-09",
        level: Level::Info,
        status: Status::Advisory,
        statement: "ASYNC-RESP, ASYNC-ST and ASYNC-TIMEOUT name receipts that were given on the same connection.",
        source: source::DERIVED,
        applies_to: "ASYNC-* over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("Progress of an operation comes that nobody knows.", |out| {
        if out.receipt().is_some() {
            out.follow(None, bug::progress(&json!("nobody-has-this")));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "the end of what never began",
        make: || {
            mutant::then(|session| {
                session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-8", "result": true }));
            })
        },
        also: &[],
    }],
};

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
                    "no reply on this connection has had the receipt {}",
                    body::quoted(&named.receipt)
                ))
                .at("/body")
            });
        }
    }
}
