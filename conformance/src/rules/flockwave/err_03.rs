//! `FW-ERR-03`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

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
    covers: &[],
    bug: Bug::message("An error code is reserved.", |out| out.set_in_state("errors", json!([300]))),
    trial: None,
    mutants: &[Mutant { name: "300", make: || fw::errors(&[300]), also: &[] }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| {
        let reserved = codes.iter().find(|code| (256..=32767).contains(*code))?;
        Some(format!("{reserved} is reserved"))
    });
}
