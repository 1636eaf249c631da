//! `FW-ERR-09`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-09",
        level: Level::Info,
        status: Status::Advisory,
        statement: "1, on the ground, doesn't stand beside 5, 6 or 63, taking off, landing and flying home.",
        source: source::DERIVED,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("A UAV stands on the ground and takes off.", |out| {
        out.set_in_state("errors", json!([1, 5]));
    }),
    trial: None,
    mutants: &[Mutant { name: "landing on the ground", make: || mutant::errors(&[1, 6]), also: &[] }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let flying = codes.iter().find(|code| [5, 6, 63].contains(*code)).filter(|_| codes.contains(&1))?;
        Some(format!("{flying} is for the air, and 1 says that the UAV is on the ground"))
    });
}
