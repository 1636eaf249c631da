//! `FW-ASY-03`.

use uavspec_flockwave::session::OPERATIONS;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-03",
    name: "No unrequested objects",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A response about several objects contains only requested objects.",
    source: source::DERIVED,
    applies_to: "commands to several objects",
    why: "An entry for another UAV suggests that the command was sent to that UAV too.",
    example: r#"→ {"type":"UAV-LAND","ids":["uav-1"]}
← {"type":"UAV-LAND","result":{"uav-1":true,"uav-2":true}}"#,
    fix: "Build the maps in the response only from the ids in the request.",
})
.checks(&[Check::Exchange(|exchange, context| reply::unrequested(exchange, context, &OPERATIONS))])
.bug(Bug::message("The response contains an object that was not requested.", |out| {
    if OPERATIONS.contains(&out.kind()) {
        out.message()["body"]["error"]["ghost-1"] = json!("there is no such object");
    }
}))
.mutants(&[Mutant::reply("an additional UAV", "UAV-TAKEOFF", |body| {
    body["error"]["hawk"] = "Asleep".into();
})]);
