//! `FW-ERR-06`.

use serde_json::json;

use std::collections::HashSet;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-06",
        level: Level::Info,
        status: Status::Advisory,
        statement: "No code stands twice in a list.",
        source: source::DERIVED,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("An error code is listed twice.", |out| out.set_in_state("errors", json!([64, 64]))),
    trial: None,
    mutants: &[Mutant { name: "a code twice", make: || mutant::errors(&[1, 1]), also: &[] }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let mut seen = HashSet::new();
        let twice = codes.iter().find(|code| !seen.insert(**code))?;
        Some(format!("{twice} stands there twice"))
    });
}
