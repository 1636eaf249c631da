//! `FW-ERR-08`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-08",
    name: "Geofence codes and the ground",
    level: Level::Should,
    status: Status::Normative,
    statement: "Code 201 (outside the geofence, in the air) is not listed together with code 1 (on the \
                ground). On the ground, code 71 is used instead.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "Code 201 is fatal and means that the UAV attempts to land. On the ground, code 201 raises a \
          false alarm.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[1,201]}}}"#
    ),
    fix: "Send code 71 instead of 201 while the UAV is on the ground.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Code 201 is sent for a UAV on the ground.", |out| {
    out.set_in_state("errors", json!([1, 201]));
}))
.mutants(&[Mutant::errors("the in-air geofence code on the ground", &[1, 201])]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        [201, 1]
            .iter()
            .all(|code| codes.contains(code))
            .then(|| "201 means that the UAV is in the air, but 1 means that it is on the ground".to_owned())
    });
}
