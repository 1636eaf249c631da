//! `FW-DEV-01`.
//!
//! `FW-INF-01` covers DEV-INF.

use super::inf_01;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-DEV-01",
    name: "Complete answer about devices",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each requested object or path appears exactly once in the response: in `devices` or \
                `success`, or in `error`.",
    source: source::MESSAGES,
    applies_to: "DEV-LIST, DEV-SUB, DEV-UNSUB",
    why: "The client does not know whether it is subscribed to a path that the response omits. The client \
          may wait for values that never arrive.",
    example: r#"→ {"type":"DEV-SUB","paths":["/uav-1/battery/voltage"]}
← {"type":"DEV-SUB","success":[]}"#,
    fix: "Add every requested object or path to `devices` or `success`, or to `error` with a reason.",
})
.checks(&[Check::Exchange(|exchange, context| {
    reply::partition(exchange, context, &["DEV-LIST", "DEV-SUB", "DEV-UNSUB"]);
})])
.covers(&[Attribution::misplaced(&["DEV-LIST", "DEV-SUB", "DEV-UNSUB"])])
.bug(
    Bug::message("DEV-LIST and DEV-INF omit the last object or path in the request.", |out| {
        out.drop_last(&["DEV-LIST", "DEV-INF"]);
    })
    .also(&[&inf_01::RULE.rule]),
)
.mutants(&[
    Mutant::reply("an object without a device tree", "DEV-LIST", |body| body["devices"] = json!({})),
    Mutant::reply("a path in both `success` and `error`", "DEV-SUB", |body| {
        body["error"]["/kite/vario"] = "Busy".into();
    }),
]);
