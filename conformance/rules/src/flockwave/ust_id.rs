//! `FW-UST-ID`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UST-ID",
    name: "Id of the UAV",
    statement: "`id` is a string.",
    why: "Clients use the id to assign the state to a UAV and to send commands to it. A state without a \
          valid id is lost.",
    example: r#"{"type":"UAV-INF","status":{"7":{"id":7,"timestamp":1790000000000}}}"#,
    fix: "Convert the id to a string.",
    ..ust::RULE
})
.checks(&[Check::Message(ust::check)])
.covers(&[
    Attribution::new(&["UAV-INF"], "status.*.id", attribution::MISSING),
    Attribution::new(&["UAV-INF"], "status.*", attribution::MISSING),
])
.bug(Bug::message("The `id` of a UAV is a number.", |out| out.set_in_state("id", json!(7))))
.mutants(&[
    Mutant::state("missing `id`", |state| mutant::remove(state, "id")),
    Mutant::state("an id that is a number", |state| state["id"] = json!(7)),
    Mutant::state("an id that is null", |state| state["id"] = json!(null)),
]);
