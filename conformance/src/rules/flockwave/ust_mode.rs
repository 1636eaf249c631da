//! `FW-UST-MODE`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule { id: "FW-UST-MODE", status: ust::NULL, statement: "`mode` is a string.", ..ust::RULE },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "mode")),
    mutants: &[
        Mutant { name: "a number", make: || ust::with("mode", json!(4)), also: &[] },
        Mutant { name: "null", make: || ust::with("mode", json!(null)), also: &[] },
    ],
};
