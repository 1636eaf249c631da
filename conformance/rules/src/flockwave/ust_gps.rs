//! `FW-UST-GPS`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-GPS",
    name: "GPS fix",
    statement: "`gps` is a list: the fix type (0 to 7), and optionally the number of satellites and the \
                horizontal and vertical accuracy in mm. Each optional element is an integer or null.",
    why: "Operators use the GPS fix to decide whether a UAV is ready for takeoff. If the fix type is \
          wrong, a UAV without a good fix may look ready.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "gps":[8,12]}}}"#,
    fix: "Map the fix type of the receiver to 0–7. Always send a list of integers, with null for unknown \
          values.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.gps.**", attribution::ALL)])
.bug(Bug::message("The GPS fix type is 8.", |out| out.set_in_state("gps", json!([8, 12]))))
.mutants(&[
    Mutant::state("a fix type of 8", |state| state["gps"] = json!([8])),
    Mutant::state("an empty list", |state| state["gps"] = json!([])),
    Mutant::state("a fix type instead of a list", |state| state["gps"] = json!(3)),
]);
