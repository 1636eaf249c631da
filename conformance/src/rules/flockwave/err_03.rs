//! `FW-ERR-03`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Codes from 256 to 32767 are reserved.",
        source: fw::ERRORS,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant { name: "300", make: || fw::errors(&[300]), also: &[] }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        let reserved = codes.iter().find(|code| (256..=32767).contains(*code))?;
        Some(format!("{reserved} is reserved"))
    });
}
