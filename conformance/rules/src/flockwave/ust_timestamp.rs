//! `FW-UST-TIMESTAMP`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-TIMESTAMP",
    name: "Time of the state",
    statement: "`timestamp` is a number of milliseconds.",
    why: "Clients compute the age of the state from its timestamp, and warn if the state is too old. \
          Without a timestamp, a lost UAV seems to be connected.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":"12:30:00"}}}"#,
    fix: "Send the time when the server received the state, as Unix time in milliseconds.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.timestamp.**", attribution::ALL)])
.bug(Bug::message("The `timestamp` of a UAV is a string.", |out| {
    out.set_in_state("timestamp", json!("noon"));
}))
.mutants(&[
    Mutant::state("missing `timestamp`", |state| mutant::remove(state, "timestamp")),
    Mutant::state("a timestamp that is a string", |state| state["timestamp"] = json!("noon")),
    Mutant::state("null", |state| state["timestamp"] = json!(null)),
]);
