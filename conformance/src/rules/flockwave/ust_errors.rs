//! `FW-UST-ERRORS`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-ERRORS",
        status: ust::NULL,
        statement: "`errors` is a list of integers.",
        ..ust::RULE
    },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "errors")),
    mutants: &[
        Mutant { name: "one code without a list", make: || ust::with("errors", json!(1)), also: &[] },
        Mutant { name: "null", make: || ust::with("errors", json!(null)), also: &[] },
    ],
};
