//! `FW-UST-VELOCITY`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-VELOCITY",
        status: ust::NULL,
        statement: "`velocity` is three integers, in mm/s: to the north, to the east and down.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "velocity"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.velocity.**", attribution::ALL)],
    bug: Bug::message("A velocity has fractions.", |out| {
        out.set_in_state("velocity", json!([0.5, 0.5, 0.5]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("velocity", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("velocity", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("velocity", json!([1.5, 0, 0])), also: &[] },
    ],
};
