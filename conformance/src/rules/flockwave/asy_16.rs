//! `FW-ASY-16`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-16",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Each receipt that was to be cancelled or resumed stands in exactly one of `success` and `error`.",
        source: fw::DERIVED,
        applies_to: "ASYNC-CANCEL, ASYNC-RESUME",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "a receipt in both",
            make: || fw::reply("ASYNC-RESUME", |body| body["error"]["rcpt-1"] = "Not now".into()),
            also: &[],
        },
        Mutant {
            name: "a receipt in none",
            make: || fw::reply("ASYNC-RESUME", |body| fw::remove(body, "error")),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::partition(exchange, context, &["ASYNC-CANCEL", "ASYNC-RESUME"]);
}
