//! `FW-UST-LIGHT`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-LIGHT",
        status: ust::NULL,
        statement: "`light` is a colour in 16 bits, an integer from 0 to 65535.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "light"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.light.**", attribution::ALL)],
    bug: Bug::message("A light has a colour of 24 bits.", |out| {
        out.set_in_state("light", json!(0x00FF_8800));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "65536", make: || ust::with("light", json!(65536)), also: &[] },
        Mutant { name: "a name", make: || ust::with("light", json!("green")), also: &[] },
    ],
};
