//! `FW-ERR-06`.

use std::collections::HashSet;

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-06",
        level: Level::Info,
        status: Status::Advisory,
        statement: "No code stands twice in a list.",
        source: fw::DERIVED,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant { name: "a code twice", make: || fw::errors(&[1, 1]), also: &[] }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        let mut seen = HashSet::new();
        let twice = codes.iter().find(|code| !seen.insert(**code))?;
        Some(format!("{twice} stands there twice"))
    });
}
