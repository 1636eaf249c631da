//! `FW-ERR-10`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-10",
        level: Level::Info,
        status: Status::Advisory,
        statement: "188 and 253 are made up for a test; they are shown.",
        source: fw::ERRORS,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant { name: "188", make: || fw::errors(&[188]), also: &[] },
        Mutant { name: "253", make: || fw::errors(&[253]), also: &[] },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        let simulated = codes.iter().find(|code| [188, 253].contains(*code))?;
        Some(format!("{simulated} is made up for a test"))
    });
}
