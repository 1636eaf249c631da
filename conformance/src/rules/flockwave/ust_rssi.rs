//! `FW-UST-RSSI`.

use serde_json::json;

use super::{Check, FlockwaveRule, Mutant, Rule, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-RSSI",
        status: ust::NULL,
        statement: "`rssi` is a list of integers from -1 to 100.",
        ..ust::RULE
    },
    check: Check::Exchange(|exchange, context| ust::check(exchange, context, "rssi")),
    mutants: &[
        Mutant { name: "-80", make: || ust::with("rssi", json!([-80])), also: &[] },
        Mutant { name: "one number without a list", make: || ust::with("rssi", json!(71)), also: &[] },
    ],
};
