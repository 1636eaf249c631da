//! `FW-UST-VELOCITY`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-VELOCITY",
    name: "Velocity",
    statement: "`velocity` is a list of three numbers in mm/s: north, east and down.",
    why: "Clients show speed and climb rate, and predict the path of the UAV. With fewer components, \
          clients cannot predict it.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "velocity":[500,500]}}}"#,
    fix: "Send north, east and down in mm/s as integers. Down is negative while the UAV climbs.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.velocity.**", attribution::ALL)])
.bug(Bug::message("The `velocity` of a UAV has two components.", |out| {
    out.set_in_state("velocity", json!([1, 2]));
}))
.mutants(&[
    Mutant::state("two components", |state| state["velocity"] = json!([1, 2])),
    Mutant::state("a string", |state| state["velocity"] = json!(["1", 0, 0])),
]);
