//! `FW-UST-ERRORS`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-ERRORS",
    name: "List of errors",
    statement: "`errors` is a list of integers.",
    why: "Clients read the error codes of a UAV from this list. If the field is not a list of integers, a \
          fatal error may stay hidden.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,
  "errors":"none"}}}"#,
    fix: "Send a list of integer codes. If there are no errors, send an empty list or omit the field.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[
    Attribution::new(&["UAV-INF"], "status.*.errors", attribution::ALL),
    Attribution::new(&["UAV-INF"], "status.*.errors.*", attribution::MISSING),
])
.bug(Bug::message("A UAV's `errors` field is a string.", |out| out.set_in_state("errors", json!("none"))))
.mutants(&[Mutant::state("a code instead of a list", |state| state["errors"] = json!(1))]);
