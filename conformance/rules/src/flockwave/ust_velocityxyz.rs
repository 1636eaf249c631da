//! `FW-UST-VELOCITYXYZ`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-VELOCITYXYZ",
    name: "Local velocity",
    statement: "`velocityXYZ` is a list of three numbers in mm/s.",
    why: "Clients predict the path of indoor UAVs from this velocity. With fewer components, clients \
          cannot predict it.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "velocityXYZ":[1500,0]}}}"#,
    fix: "Send X, Y and Z in mm/s as integers. If there is no velocity, omit the field.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.velocityXYZ.**", attribution::ALL)])
.bug(Bug::message("The `velocityXYZ` of a UAV has two components.", |out| {
    out.set_in_state("velocityXYZ", json!([1, 2]));
}))
.mutants(&[
    Mutant::state("two components", |state| state["velocityXYZ"] = json!([1, 2])),
    Mutant::state("a string", |state| state["velocityXYZ"] = json!(["1", 0, 0])),
]);
