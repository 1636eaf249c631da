//! `FW-UST-POSITIONXYZ`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-POSITIONXYZ",
        status: ust::NULL,
        statement: "`positionXYZ` is three integers, in mm.",
        ..ust::RULE
    },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "positionXYZ")),
    mutants: &[
        Mutant { name: "null", make: || ust::with("positionXYZ", json!(null)), also: &[] },
        Mutant { name: "two", make: || ust::with("positionXYZ", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("positionXYZ", json!([1.5, 0, 0])), also: &[] },
    ],
};
