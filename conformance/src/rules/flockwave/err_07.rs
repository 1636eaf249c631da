//! `FW-ERR-07`.

use serde_json::json;

use super::{
    Bug, Check, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-07",
        level: Level::Should,
        status: Status::Disputed(
            "The text of code 65 names 131 as its alternative, which has nothing to do with it; 132 is meant.",
        ),
        statement: "Codes that are alternatives don't stand together: 65 and 132; 66, 134 and 199; 133 and 197; 71 and 201; 72 and 139.",
        source: source::ERRORS,
        applies_to: "`errors` of UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("A battery is low in two ways.", |out| out.set_in_state("errors", json!([66, 134]))),
    trial: None,
    mutants: &[
        Mutant { name: "both on the battery", make: || mutant::errors(&[66, 134]), also: &[] },
        Mutant { name: "both on the fence", make: || mutant::errors(&[71, 201]), also: &[] },
    ],
};

const ALTERNATIVES: [&[i128]; 5] = [&[65, 132], &[66, 134, 199], &[133, 197], &[71, 201], &[72, 139]];

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let both = ALTERNATIVES.iter().find_map(|group| {
            let mut found = group.iter().filter(|code| codes.contains(code));
            found.next().zip(found.next())
        });
        both.map(|(one, other)| format!("{one} and {other} are alternatives"))
    });
}
