//! `FW-UST-POSITION`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-POSITION",
    name: "Position",
    statement: "`position` is a list: latitude (-90° to 90°) and longitude (-180° to 180°) in 1e-7 \
                degrees, then up to three altitudes in mm. Each altitude is a number or null.",
    why: "Clients use these values to place the UAV on the map. Without a valid longitude, clients cannot \
          show the UAV.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "position":[465410000]}}}"#,
    fix: "Multiply degrees by 10,000,000 and metres by 1,000, and round to integers. If there is no \
          position, omit the field.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.position.**", attribution::ALL)])
.bug(Bug::message("The latitude of a UAV is beyond the pole.", |out| {
    out.set_in_state("position", json!([900_000_001, 0]));
}))
.mutants(&[
    Mutant::state("a longitude beyond 180°", |state| state["position"] = json!([0, 1_800_000_001])),
    Mutant::state("a latitude of 180°", |state| state["position"] = json!([1_800_000_000, 0])),
    Mutant::state("a missing longitude", |state| state["position"] = json!([465_410_000])),
    Mutant::state("six elements", |state| {
        state["position"] = json!([465_410_000, 115_520_000, 1, 2, 3, 4]);
    }),
]);
