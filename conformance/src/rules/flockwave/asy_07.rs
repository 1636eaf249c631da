//! `FW-ASY-07`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-07",
        level: Level::Must,
        status: Status::Normative,
        statement: "ASYNC-RESP has exactly one of `result` and `error`.",
        source: fw::ASYNC,
        applies_to: "ASYNC-RESP",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "both",
            make: || fw::notice("ASYNC-RESP", |body| body["error"] = "Winch broke".into()),
            also: &[],
        },
        Mutant {
            name: "neither",
            make: || fw::notice("ASYNC-RESP", |body| fw::remove(body, "result")),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-RESP").is_some() {
        fw::exactly_one(exchange, context, &["result", "error"], "result");
    }
}
