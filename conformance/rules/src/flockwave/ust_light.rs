//! `FW-UST-LIGHT`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-LIGHT",
    name: "Light colour",
    statement: "`light` is a 16-bit colour, an integer from 0 to 65535.",
    why: "Clients show the light of each UAV, for example in a drone show. A colour in a different format \
          is displayed incorrectly.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "light":16746496}}}"#,
    fix: "Convert the colour to RGB565: 5 bits for red, 6 bits for green, and 5 bits for blue.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.light.**", attribution::ALL)])
.bug(Bug::message("The `light` of a UAV is a 24-bit colour.", |out| {
    out.set_in_state("light", json!(0x00FF_8800));
}))
.mutants(&[
    Mutant::state("a colour of 65536", |state| state["light"] = json!(65536)),
    Mutant::state("a colour name", |state| state["light"] = json!("green")),
]);
