//! `FW-UST-BATTERY`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-BATTERY",
    name: "Battery",
    statement: "`battery` is a list: the voltage in tenths of a volt (integer, 0 or more), and optionally \
                the percentage (integer, at most 100) and a boolean that is true while charging.",
    why: "Operators use the battery level to decide when a UAV has to land. If the value or its unit is \
          wrong, a nearly empty battery may look full.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "battery":[11.8,84]}}}"#,
    fix: "Send the voltage as an integer in tenths of a volt (11.8 V is 118). Send a percentage of at \
          most 100, or -1 if it is unknown.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.battery.**", attribution::ALL)])
.bug(Bug::message("The battery percentage is 101.", |out| out.set_in_state("battery", json!([126, 101]))))
.mutants(&[
    Mutant::state("a fractional voltage", |state| state["battery"] = json!([11.8, 84])),
    Mutant::state("101 percent", |state| state["battery"] = json!([118, 101])),
    Mutant::state("a number in place of a boolean", |state| state["battery"] = json!([118, 84, 1])),
]);
