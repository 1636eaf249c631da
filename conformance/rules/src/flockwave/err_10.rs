//! `FW-ERR-10`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-10",
    name: "Simulated errors",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Codes 188 and 253 are simulated errors for tests. uavspec reports each use.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "A simulated error triggers a return to home or an emergency landing. Simulated errors should \
          not appear in normal operation.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[188]}}}"#
    ),
    fix: "Turn off the error simulation outside tests. In a test, ignore this finding.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("A simulated error is sent.", |out| out.set_in_state("errors", json!([188]))))
.mutants(&[
    Mutant::errors("the simulated error 188", &[188]),
    Mutant::errors("the simulated fatal error 253", &[253]),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let simulated = codes.iter().find(|code| [188, 253].contains(*code))?;
        Some(format!("{simulated} is a simulated error"))
    });
}
