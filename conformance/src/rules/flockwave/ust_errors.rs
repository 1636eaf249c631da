//! `FW-UST-ERRORS`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-ERRORS",
        status: ust::NULL,
        statement: "`errors` is a list of integers.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "errors"))],
    covers: &[
        Attribution::new(&["UAV-INF"], "status.*.errors", attribution::ALL),
        Attribution::new(&["UAV-INF"], "status.*.errors.*", attribution::MISSING),
    ],
    bug: Bug::message("Error codes are a text.", |out| out.set_in_state("errors", json!("none"))),
    trial: None,
    mutants: &[
        Mutant { name: "one code without a list", make: || ust::with("errors", json!(1)), also: &[] },
        Mutant { name: "null", make: || ust::with("errors", json!(null)), also: &[] },
    ],
};
