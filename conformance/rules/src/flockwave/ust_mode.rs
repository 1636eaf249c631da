//! `FW-UST-MODE`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-MODE",
    name: "Flight mode",
    statement: "`mode` is a string.",
    why: "Clients show the flight mode, for example whether the UAV is returning to home. \
          Autopilot-specific mode numbers mean nothing to clients.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "mode":4}}}"#,
    fix: "Map the mode of the autopilot to a name in the specification, or send another string such as \
          `other`.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.mode.**", attribution::ALL)])
.bug(Bug::message("The `mode` of a UAV is a number.", |out| out.set_in_state("mode", json!(4))))
.mutants(&[Mutant::state("a mode that is a number", |state| state["mode"] = json!(4))]);
