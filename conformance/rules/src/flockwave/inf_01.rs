//! `FW-INF-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-INF-01",
    name: "Complete answer about ids or paths",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each requested id or path is in exactly one of the maps in the response.",
    source: source::MESSAGES,
    applies_to: "BCN-INF, CLK-INF, DEV-INF, DOCK-INF, EXT-INF, FW-TARGET-INF, RTK-INF, UAV-PREFLT, WTH-INF",
    why: "If an object is missing, the client cannot tell whether it is unknown or was forgotten, and \
          keeps showing old data.",
    example: r#"→ {"type":"WTH-INF","ids":["mast-1","mast-2"]}
← {"type":"WTH-INF","error":{"mast-1":"No data yet"}}"#,
    fix: "Add an entry for every requested id or path: its data, or a reason in `error`.",
})
.checks(&[Check::Exchange(|exchange, context| reply::partition(exchange, context, &TYPES))])
.covers(&[Attribution::misplaced(&TYPES)])
.bug(Bug::message("BCN-INF and similar responses omit the last object in the request.", |out| {
    out.drop_last(&["BCN-INF", "CLK-INF", "WTH-INF", "RTK-INF", "EXT-INF", "UAV-PREFLT"]);
}))
.mutants(&[
    Mutant::reply("BCN-INF has no data for a requested object", "BCN-INF", |body| {
        body["status"] = json!({});
    }),
    Mutant::reply("UAV-PREFLT has its data in an undefined field", "UAV-PREFLT", |body| {
        body["result"] = body["status"].take();
        mutant::remove(body, "status");
    }),
    Mutant::reply("CLK-INF has no data for a requested object", "CLK-INF", |body| {
        body["status"] = json!({});
    }),
    Mutant::reply("DEV-INF has no data for a requested object", "DEV-INF", |body| {
        body["values"] = json!({});
    }),
    Mutant::reply("EXT-INF has no data for a requested object", "EXT-INF", |body| {
        body["status"] = json!({});
    }),
    Mutant::reply("RTK-INF has no data for a requested object", "RTK-INF", |body| {
        body["preset"] = json!({});
    }),
    Mutant::reply("UAV-PREFLT has no data for a requested object", "UAV-PREFLT", |body| {
        body["status"] = json!({});
    }),
    Mutant::reply("WTH-INF has no data for a requested object", "WTH-INF", |body| {
        body["status"] = json!({});
    }),
]);

const TYPES: [&str; 9] = [
    "BCN-INF",
    "CLK-INF",
    "DEV-INF",
    "DOCK-INF",
    "EXT-INF",
    "FW-TARGET-INF",
    "RTK-INF",
    "UAV-PREFLT",
    "WTH-INF",
];
