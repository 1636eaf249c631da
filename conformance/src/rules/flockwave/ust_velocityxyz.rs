//! `FW-UST-VELOCITYXYZ`.

use serde_json::{Value, json};

use super::{Attribution, Bug, Check, FlockwaveRule, Mutant, Rule, attribution, ust};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UST-VELOCITYXYZ",
        status: ust::NULL,
        statement: "`velocityXYZ` is a list of three integers in mm/s.",
        why: "Clients predict the path of indoor UAVs from this velocity. If it is in m/s instead of mm/s, a moving \
              UAV seems to hover.",
        example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "velocityXYZ":[1.5,0,0]}}}"#,
        fix: "Send X, Y and Z in mm/s as integers. If there is no velocity, omit the field.",
        ..ust::RULE
    },
    checks: &[Check::Message(|message, context| ust::check(message, context, &RULE, "velocityXYZ"))],
    covers: &[Attribution::new(&["UAV-INF"], "status.*.velocityXYZ.**", attribution::ALL)],
    bug: Bug::message("The `velocityXYZ` of a UAV is null.", |out| {
        out.set_in_state("velocityXYZ", Value::Null);
    }),
    trial: None,
    mutants: &[
        Mutant { name: "null", make: || ust::with("velocityXYZ", json!(null)), also: &[] },
        Mutant { name: "two components", make: || ust::with("velocityXYZ", json!([1, 2])), also: &[] },
        Mutant { name: "a fraction", make: || ust::with("velocityXYZ", json!([1.5, 0, 0])), also: &[] },
    ],
};
