//! `FW-UST-POSITION`.

use serde_json::json;

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-POSITION",
        status: ust::NULL,
        statement: "`position` is latitude and longitude, integers in units of 1e-7 degrees, and up to three altitudes in mm, integers or null.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "position"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.position.**", attribution::ALL)],
    bug: Bug::message("A latitude lies beyond the pole.", |out| {
        out.set_in_state("position", json!([900_000_001, 0]));
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("position", json!(null)), also: &[] },
        Mutant { name: "degrees", make: || ust::with("position", json!([46.541, 11.552])), also: &[] },
        Mutant {
            name: "a longitude of 180°",
            make: || ust::with("position", json!([0, 1_800_000_000])),
            also: &[],
        },
        Mutant { name: "no longitude", make: || ust::with("position", json!([465_410_000])), also: &[] },
        Mutant {
            name: "six elements",
            make: || ust::with("position", json!([465_410_000, 115_520_000, 1, 2, 3, 4])),
            also: &[],
        },
    ],
};
