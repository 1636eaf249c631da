//! `FW-ASY-04I`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Stage, Status, asy_10,
    asy_22, body, mutant, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-04I",
        level: Level::Info,
        status: Status::Advisory,
        statement: "No two operations under way on a connection have the same receipt.",
        source: source::DERIVED,
        applies_to: "replies with `receipt` over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::behaviour("All operations have the same receipt.")
        .with(&[&asy_10::RULE.rule, &asy_22::RULE.rule]),
    trial: None,
    mutants: &[Mutant {
        name: "two gliders with the same receipt",
        make: || {
            let same = json!({ "receipt": { "kite": "rcpt-8", "swift": "rcpt-8" } });
            let request = json!({ "type": "UAV-RTH", "ids": ["kite", "swift"] });
            mutant::then(|session| session.exchange(request, same))
        },
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for named in exchange.opened.iter().filter(|named| named.is_known) {
        context.covered();
        if matches!(named.stage(), Some(Stage::Open | Stage::Suspended | Stage::Released)) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "{} is the receipt of another operation, too",
                    body::quoted(&named.receipt)
                ))
                .at("/body/receipt")
            });
        }
    }
}
