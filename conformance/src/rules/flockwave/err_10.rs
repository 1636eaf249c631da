//! `FW-ERR-10`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-10",
        level: Level::Info,
        status: Status::Advisory,
        statement: "188 and 253 are made up for a test; they are shown.",
        source: source::ERRORS,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("An error is simulated.", |out| out.set_in_state("errors", json!([188]))),
    trial: None,
    mutants: &[
        Mutant { name: "188", make: || mutant::errors(&[188]), also: &[] },
        Mutant { name: "253", make: || mutant::errors(&[253]), also: &[] },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let simulated = codes.iter().find(|code| [188, 253].contains(*code))?;
        Some(format!("{simulated} is made up for a test"))
    });
}
