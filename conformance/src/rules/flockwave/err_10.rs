//! `FW-ERR-10`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

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
    covers: &[],
    bug: Bug::message("An error is simulated.", |out| out.set_in_state("errors", json!([188]))),
    trial: None,
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
