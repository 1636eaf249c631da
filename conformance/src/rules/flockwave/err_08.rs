//! `FW-ERR-08`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-08",
        level: Level::Should,
        status: Status::Normative,
        statement: "201, outside the fence in the air, doesn't stand beside 1, on the ground; 71 does.",
        source: source::ERRORS,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("On the ground a UAV has left the fence in the air.", |out| {
        out.set_in_state("errors", json!([1, 201]));
    }),
    trial: None,
    mutants: &[Mutant {
        name: "outside the fence, on the ground",
        make: || mutant::errors(&[1, 201]),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        [201, 1]
            .iter()
            .all(|code| codes.contains(code))
            .then(|| "201 is for the air, and 1 says that the UAV is on the ground".to_owned())
    });
}
