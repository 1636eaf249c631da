//! `FW-ERR-02`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-02",
        level: Level::Should,
        status: Status::Normative,
        statement: "0 isn't listed: an empty list says that there is no error.",
        source: source::ERRORS,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("The absence of errors is listed.", |out| out.set_in_state("errors", json!([0]))),
    trial: None,
    mutants: &[
        Mutant { name: "0", make: || mutant::errors(&[0]), also: &[] },
        Mutant { name: "0 beside another", make: || mutant::errors(&[0, 1]), also: &[] },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| codes.contains(&0).then(|| "0 is listed".to_owned()));
}
