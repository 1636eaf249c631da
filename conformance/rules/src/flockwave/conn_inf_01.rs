//! `FW-CONN-INF-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-CONN-INF-01",
    name: "Complete answer about connections",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each requested connection is in exactly one of `status` and `error` of the response.",
    source: source::MESSAGES,
    applies_to: "CONN-INF",
    why: "The client does not know whether the connection is down, is unknown or was omitted by mistake.",
    example: r#"→ {"type":"CONN-INF","ids":["radio-1","radio-2"]}
← {"type":"CONN-INF","error":{"radio-1":"Unknown connection"}}"#,
    fix: "Add an entry for every requested id: its state in `status`, or a reason in `error`.",
})
.checks(&[Check::Exchange(|exchange, context| reply::partition(exchange, context, &["CONN-INF"]))])
.covers(&[Attribution::misplaced(&["CONN-INF"])])
.bug(Bug::message("CONN-INF omits the last connection in the request.", |out| out.drop_last(&["CONN-INF"])))
.mutants(&[Mutant::reply("a missing connection", "CONN-INF", |body| body["error"] = json!({}))]);
