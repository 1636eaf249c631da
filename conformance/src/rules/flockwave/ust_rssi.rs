//! `FW-UST-RSSI`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-RSSI",
        status: ust::NULL,
        statement: "`rssi` is a list of integers from -1 to 100.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "rssi"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.rssi.**", attribution::ALL)],
    bug: Bug::message("A signal is weaker than none.", |out| out.set_in_state("rssi", json!([-60]))),
    trial: None,
    mutants: &[
        Mutant { name: "-80", make: || ust::with("rssi", json!([-80])), also: &[] },
        Mutant { name: "one number without a list", make: || ust::with("rssi", json!(71)), also: &[] },
    ],
};
