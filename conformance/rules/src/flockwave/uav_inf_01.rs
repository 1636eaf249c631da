//! `FW-UAV-INF-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-01",
    name: "Complete answer about UAVs",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each requested UAV is in exactly one of `status` and `error` of the response.",
    source: source::MESSAGES,
    applies_to: "UAV-INF",
    why: "If a UAV is missing, the client cannot tell whether it is unknown or was forgotten, and keeps \
          showing its old position.",
    example: r#"→ {"type":"UAV-INF","ids":["uav-1","uav-2"]}
← {"type":"UAV-INF","error":{"uav-1":"Unknown UAV"}}"#,
    fix: "Add an entry for every requested id: its state in `status`, or a reason in `error`.",
})
.checks(&[Check::Exchange(|exchange, context| reply::partition(exchange, context, &["UAV-INF"]))])
.covers(&[Attribution::misplaced(&["UAV-INF"])])
.bug(Bug::message("UAV-INF omits the last UAV in the request.", |out| out.drop_last(&["UAV-INF"])))
.mutants(&[
    Mutant::reply("a missing UAV", "UAV-INF", |body| mutant::remove(body, "error")),
    Mutant::reply("a UAV in both maps", "UAV-INF", |body| body["error"]["kite"] = "Asleep".into()),
]);
