//! `FW-UST-VELOCITYXYZ`.

use serde_json::{Value, json};

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-VELOCITYXYZ",
        status: ust::NULL,
        statement: "`velocityXYZ` is three integers, in mm/s.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "velocityXYZ"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.velocityXYZ.**", attribution::ALL)],
    bug: Bug::message("A velocity in the flat frame is null.", |out| {
        out.set_in_state("velocityXYZ", Value::Null);
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("velocityXYZ", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("velocityXYZ", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("velocityXYZ", json!([1.5, 0, 0])), also: &[] },
    ],
};
