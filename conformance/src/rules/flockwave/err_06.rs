//! `FW-ERR-06`.

use serde_json::json;

use std::collections::HashSet;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

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
    covers: &[],
    bug: Bug::message("An error code is listed twice.", |out| out.set_in_state("errors", json!([64, 64]))),
    trial: None,
    mutants: &[Mutant { name: "a code twice", make: || fw::errors(&[1, 1]), also: &[] }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        let mut seen = HashSet::new();
        let twice = codes.iter().find(|code| !seen.insert(**code))?;
        Some(format!("{twice} stands there twice"))
    });
}
