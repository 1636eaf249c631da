//! `FW-UST-GPS`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-GPS",
        status: ust::NULL,
        statement: "`gps` is the type of the fix, 0 to 7; then the number of satellites, and the horizontal and the vertical accuracy in mm, integers or null.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "gps"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.gps.**", attribution::ALL)],
    bug: Bug::message("A GPS fix is of a kind that there isn't.", |out| {
        out.set_in_state("gps", json!([8, 12]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "a fix of 8", make: || ust::with("gps", json!([8])), also: &[] },
        Mutant { name: "nothing", make: || ust::with("gps", json!([])), also: &[] },
        Mutant { name: "the fix alone, without a list", make: || ust::with("gps", json!(3)), also: &[] },
    ],
};
