//! `FW-UAV-INF-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-03",
    name: "Keys of UAV states",
    level: Level::Must,
    status: Status::Normative,
    statement: "The key of each state in `status` equals the `id` in that state.",
    source: source::MESSAGES,
    applies_to: "UAV-INF",
    why: "Clients that index by key and clients that index by `id` assign position and battery to \
          different UAVs.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-2","timestamp":1790000000000}}}"#,
    fix: "Use the `id` of each state as its key in `status`.",
})
.checks(&[Check::Message(|message, context| body::keyed(message, context, "UAV-INF"))])
.bug(Bug::message("The `id` of a UAV differs from its key.", |out| out.set_in_state("id", json!("ghost-1"))))
.mutants(&[Mutant::state("an id that differs from its key", |state| state["id"] = "hawk".into())]);
