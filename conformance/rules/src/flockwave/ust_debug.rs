//! `FW-UST-DEBUG`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-DEBUG",
    name: "Debug data",
    level: Level::Should,
    status: Status::Advisory,
    statement: "`debug` is a Base64 string.",
    why: "Clients decode the field before they pass it on to debugging tools. An invalid string may make \
          a client reject the whole status report.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "debug":"all is well!"}}}"#,
    fix: "Encode the data with standard Base64 (RFC 4648), including the padding.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.debug.**", attribution::ALL)])
.bug(Bug::message("The `debug` field is not Base64.", |out| out.set_in_state("debug", json!("all is well!"))))
.mutants(&[
    Mutant::state("a string that is not Base64", |state| state["debug"] = json!("glide!")),
    Mutant::state("a number", |state| state["debug"] = json!(7)),
]);
