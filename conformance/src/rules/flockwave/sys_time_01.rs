//! `FW-SYS-TIME-01`.

use super::fw::{self, Exchange, INTEGER};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-TIME-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "`timestamp` is an integer, in milliseconds.",
        source: fw::MESSAGES,
        applies_to: "SYS-TIME",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "seconds with a fraction",
            make: || fw::reply("SYS-TIME", |body| body["timestamp"] = 1_790_000_000.25.into()),
            also: &[],
        },
        Mutant {
            name: "a string",
            make: || fw::reply("SYS-TIME", |body| body["timestamp"] = "noon".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-TIME").is_some() {
        fw::field(exchange, context, "timestamp", true, &INTEGER);
    }
}
