//! `FW-UST-DEBUG`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule { id: "FW-UST-DEBUG", status: ust::NULL, statement: "`debug` is Base64.", ..ust::RULE },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "debug"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.debug.**", attribution::ALL)],
    bug: Bug::message("What is for debugging isn't in Base64.", |out| {
        out.set_in_state("debug", json!("all is well!"));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "no Base64", make: || ust::with("debug", json!("glide!")), also: &[] },
        Mutant { name: "a number", make: || ust::with("debug", json!(7)), also: &[] },
    ],
};
