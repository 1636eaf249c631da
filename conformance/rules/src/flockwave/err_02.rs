//! `FW-ERR-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-02",
    name: "No code 0 in the list",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The list of errors does not contain 0; an empty list means that there are no errors.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "If the list contains 0, a client that shows each entry as a problem reports a healthy UAV as \
          faulty.",
    example: r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"errors":[0]}}}"#,
    fix: "Send an empty list, or omit `errors`, if there are no errors.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("The error code 0 is sent.", |out| out.set_in_state("errors", json!([0]))))
.mutants(&[Mutant::errors("0 alone", &[0]), Mutant::errors("0 next to another code", &[0, 1])]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| codes.contains(&0).then(|| "0 is listed".to_owned()));
}
