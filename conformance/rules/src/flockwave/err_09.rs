//! `FW-ERR-09`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-09",
    name: "On the ground or in the air",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Code 1 (on the ground) is not listed together with 5 (taking off), 6 (landing) or 63 \
                (returning to home).",
    source: source::DERIVED,
    applies_to: "`errors` of UAV-INF",
    why: "The client does not know whether the UAV is flying. An operator may approach a UAV whose \
          propellers are turning.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[1,5]}}}"#
    ),
    fix: "Remove code 1 when the takeoff starts, and add it again when the landing is complete.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("A UAV is reported as both on the ground and taking off.", |out| {
    out.set_in_state("errors", json!([1, 5]));
}))
.mutants(&[Mutant::errors("both landing and on the ground", &[1, 6])]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let flying = codes.iter().find(|code| [5, 6, 63].contains(*code)).filter(|_| codes.contains(&1))?;
        Some(format!("{flying} means that the UAV is in flight, but 1 means that it is on the ground"))
    });
}
