//! `FW-ERR-03`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Codes from 256 to 32767 are reserved.",
        source: source::ERRORS,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("An error code is reserved.", |out| out.set_in_state("errors", json!([300]))),
    trial: None,
    mutants: &[Mutant { name: "300", make: || mutant::errors(&[300]), also: &[] }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let reserved = codes.iter().find(|code| (256..=32767).contains(*code))?;
        Some(format!("{reserved} is reserved"))
    });
}
