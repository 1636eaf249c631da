//! `FW-UST-ATTITUDE`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-ATTITUDE",
    name: "Attitude",
    statement: "`attitude` is a list of three integers in tenths of a degree: roll and pitch from -1800 \
                to 1799, and yaw from 0 to 3599.",
    why: "Clients draw the attitude from these values. If they are in radians or whole degrees, a steeply \
          tilted UAV seems to be level.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "attitude":[0,0,3600]}}}"#,
    fix: "Send three integers in tenths of a degree. Wrap yaw to the range 0 to 3599, and roll and pitch \
          to the range -1800 to 1799.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.attitude.**", attribution::ALL)])
.bug(Bug::message("The roll of a UAV is 1800.", |out| out.set_in_state("attitude", json!([1800, 0, 0]))))
.mutants(&[
    Mutant::state("a yaw of 3600", |state| state["attitude"] = json!([0, 0, 3600])),
    Mutant::state("a missing yaw", |state| state["attitude"] = json!([0, 0])),
]);
