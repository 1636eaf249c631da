//! `FW-UST-ATTITUDE`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-ATTITUDE",
        status: ust::NULL,
        statement: "`attitude` is roll and pitch, integers from -1800 to 1799, and yaw, 0 to 3599, in tenths of a degree.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "attitude"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.attitude.**", attribution::ALL)],
    bug: Bug::message("A roll is half a turn to the right.", |out| {
        out.set_in_state("attitude", json!([1800, 0, 0]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("attitude", json!(null)), also: &[] },
        Mutant { name: "a yaw of 3600", make: || ust::with("attitude", json!([0, 0, 3600])), also: &[] },
        Mutant { name: "no yaw", make: || ust::with("attitude", json!([0, 0])), also: &[] },
    ],
};
