//! `FW-ASY-02`.

use uavspec_flockwave::session::OPERATIONS;

use super::asy_09;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-02",
    name: "Response about several objects",
    level: Level::Must,
    status: Status::Normative,
    statement: "In a response about several objects, each requested object is in exactly one of `result`, \
                `error` and `receipt`.",
    source: source::ASYNC,
    applies_to: "commands to several objects",
    why: "The client does not know whether an omitted UAV received the command. The operator may assume \
          that the UAV received it, or may send the command twice.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1","uav-2"]}
← {"type":"UAV-TAKEOFF","result":{"uav-1":true}}"#,
    fix: "Add one entry for every requested id: to `result` after success, to `error` after failure, or \
          to `receipt` while the operation is pending.",
})
.checks(&[Check::Exchange(|exchange, context| reply::partition(exchange, context, &OPERATIONS))])
.covers(&[Attribution::misplaced(&OPERATIONS)])
.bug(
    Bug::message("The response omits the last object in the request.", |out| {
        out.drop_last(&OPERATIONS);
    })
    .also(&[&asy_09::RULE.rule]),
)
.mutants(&[
    Mutant::reply("a missing UAV", "UAV-TAKEOFF", |body| mutant::remove(body, "result")),
    Mutant::reply("a UAV in two maps", "UAV-TAKEOFF", |body| body["result"]["owl"] = true.into()),
]);
