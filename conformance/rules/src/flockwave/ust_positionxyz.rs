//! `FW-UST-POSITIONXYZ`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-POSITIONXYZ",
    name: "Local position",
    statement: "`positionXYZ` is a list of three numbers in mm.",
    why: "Clients use these coordinates to place indoor UAVs. With fewer coordinates, clients cannot show \
          the UAV.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "positionXYZ":[1500,0]}}}"#,
    fix: "Send X, Y and Z in millimetres as integers. If there is no position, omit the field.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.positionXYZ.**", attribution::ALL)])
.bug(Bug::message("The `positionXYZ` of a UAV has two coordinates.", |out| {
    out.set_in_state("positionXYZ", json!([1, 2]));
}))
.mutants(&[
    Mutant::state("two coordinates", |state| state["positionXYZ"] = json!([1, 2])),
    Mutant::state("a string", |state| state["positionXYZ"] = json!(["1", 0, 0])),
]);
