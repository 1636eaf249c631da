//! `FW-ASY-20`.

use super::fw::{self, Exchange, Shape};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-20",
        level: Level::Must,
        status: Status::Normative,
        statement: "ASYNC-TIMEOUT has `ids`, a list of strings.",
        source: fw::ASYNC,
        applies_to: "ASYNC-TIMEOUT",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "one id without a list",
        make: || fw::notice("ASYNC-TIMEOUT", |body| body["ids"] = "rcpt-2".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-TIMEOUT").is_some() {
        fw::field(exchange, context, "ids", true, &Shape::List(&Shape::Text));
    }
}
