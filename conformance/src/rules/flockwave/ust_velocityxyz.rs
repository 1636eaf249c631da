//! `FW-UST-VELOCITYXYZ`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-VELOCITYXYZ",
        status: ust::NULL,
        statement: "`velocityXYZ` is three integers, in mm/s.",
        ..ust::RULE
    },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "velocityXYZ")),
    mutants: &[
        Mutant { name: "null", make: || ust::with("velocityXYZ", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("velocityXYZ", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("velocityXYZ", json!([1.5, 0, 0])), also: &[] },
    ],
};
