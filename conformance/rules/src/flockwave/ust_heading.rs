//! `FW-UST-HEADING`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-HEADING",
    name: "Heading",
    statement: "`heading` is an integer from 0 to 3599, in tenths of a degree.",
    why: "Clients rotate the symbol of the UAV by this value. If it is in degrees or radians, the symbol \
          points in the wrong direction.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "heading":3600}}}"#,
    fix: "Multiply degrees by 10, round to an integer, and take the result modulo 3600.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.heading.**", attribution::ALL)])
.bug(Bug::message("The heading of a UAV is 3600.", |out| out.set_in_state("heading", json!(3600))))
.mutants(&[
    Mutant::state("a heading of 3600", |state| state["heading"] = json!(3600)),
    Mutant::state("a heading of -1", |state| state["heading"] = json!(-1)),
    Mutant::state("a fractional heading", |state| state["heading"] = json!(271.5)),
]);
