//! `FW-UST-POSITIONXYZ`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-POSITIONXYZ",
        status: ust::NULL,
        statement: "`positionXYZ` is three integers, in mm.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "positionXYZ"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.positionXYZ.**", attribution::ALL)],
    bug: Bug::message("A position in the flat frame has two coordinates.", |out| {
        out.set_in_state("positionXYZ", json!([1, 2]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("positionXYZ", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("positionXYZ", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("positionXYZ", json!([1.5, 0, 0])), also: &[] },
    ],
};
