//! `FW-UST-RSSI`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-RSSI",
    name: "Signal strength",
    statement: "`rssi` is a list of integers from -1 to 100.",
    why: "Clients show the signal strength as a percentage. Values in dBm, such as -80, are shown as no \
          signal or as an invalid bar.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "rssi":[-80]}}}"#,
    fix: "Scale the signal strength to 0–100 for each channel, and send -1 for a channel without a reading.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.rssi.**", attribution::ALL)])
.bug(Bug::message("The `rssi` of a UAV is -60.", |out| out.set_in_state("rssi", json!([-60]))))
.mutants(&[
    Mutant::state("a value of -80", |state| state["rssi"] = json!([-80])),
    Mutant::state("a number instead of a list", |state| state["rssi"] = json!(71)),
]);
