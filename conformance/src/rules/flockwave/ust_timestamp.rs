//! `FW-UST-TIMESTAMP`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, Status, attribution, mutant, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-TIMESTAMP",
        status: Status::Normative,
        statement: "`timestamp` is an integer, in milliseconds.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "timestamp"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.timestamp.**", attribution::ALL)],
    bug: Bug::message("A time stamp is a text.", |out| {
        out.set_in_state("timestamp", json!("noon"));
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "no `timestamp`",
            make: || mutant::state(|kite| mutant::remove(kite, "timestamp")),
            also: &[],
        },
        Mutant { name: "a word", make: || ust::with("timestamp", json!("noon")), also: &[] },
        Mutant { name: "null", make: || ust::with("timestamp", json!(null)), also: &[] },
    ],
};
