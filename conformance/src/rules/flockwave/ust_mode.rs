//! `FW-UST-MODE`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule { id: "FW-UST-MODE", status: ust::NULL, statement: "`mode` is a string.", ..ust::RULE },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "mode"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.mode.**", attribution::ALL)],
    bug: Bug::message("A mode is a number.", |out| out.set_in_state("mode", json!(4))),
    trial: None,
    mutants: &[
        Mutant { name: "a number", make: || ust::with("mode", json!(4)), also: &[] },
        Mutant { name: "null", make: || ust::with("mode", json!(null)), also: &[] },
    ],
};
