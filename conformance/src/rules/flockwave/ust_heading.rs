//! `FW-UST-HEADING`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-HEADING",
        status: ust::NULL,
        statement: "`heading` is an integer from 0 to 3599, in tenths of a degree.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "heading"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.heading.**", attribution::ALL)],
    bug: Bug::message("A heading is a full turn.", |out| out.set_in_state("heading", json!(3600))),
    trial: None,
    mutants: &[
        Mutant { name: "3600", make: || ust::with("heading", json!(3600)), also: &[] },
        Mutant { name: "-1", make: || ust::with("heading", json!(-1)), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("heading", json!(271.5)), also: &[] },
    ],
};
