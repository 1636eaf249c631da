//! `FW-UST-VELOCITY`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-VELOCITY",
        status: ust::NULL,
        statement: "`velocity` is three integers, in mm/s: to the north, to the east and down.",
        ..ust::RULE
    },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "velocity")),
    mutants: &[
        Mutant { name: "null", make: || ust::with("velocity", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("velocity", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("velocity", json!([1.5, 0, 0])), also: &[] },
    ],
};
