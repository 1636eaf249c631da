//! `FW-UST-DEBUG`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule { id: "FW-UST-DEBUG", status: ust::NULL, statement: "`debug` is Base64.", ..ust::RULE },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "debug")),
    mutants: &[
        Mutant { name: "no Base64", make: || ust::with("debug", json!("glide!")), also: &[] },
        Mutant { name: "a number", make: || ust::with("debug", json!(7)), also: &[] },
    ],
};
