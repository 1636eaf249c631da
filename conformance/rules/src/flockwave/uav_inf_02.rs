//! `FW-UAV-INF-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-02",
    name: "No unrequested UAVs",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A UAV-INF response contains only requested UAVs.",
    source: source::DERIVED,
    applies_to: "UAV-INF",
    why: "The client may show an unrequested UAV even if the operator has filtered it out.",
    example: r#"→ {"type":"UAV-INF","ids":["uav-9"]}
← {"type":"UAV-INF","error":{"uav-9":"Unknown UAV","uav-8":"Unknown UAV"}}"#,
    fix: "Build the maps in the response only from the ids in the request.",
})
.checks(&[Check::Exchange(|exchange, context| reply::unrequested(exchange, context, &["UAV-INF"]))])
.bug(Bug::message("UAV-INF contains a UAV that was not requested.", |out| {
    if !out.is_notification()
        && let Some(mut state) = out.state().cloned()
    {
        state["id"] = json!("ghost-1");
        out.message()["body"]["status"]["ghost-1"] = state;
    }
}))
.mutants(&[Mutant::reply("an additional UAV", "UAV-INF", |body| body["error"]["hawk"] = "Asleep".into())]);
