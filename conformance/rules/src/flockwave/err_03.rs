//! `FW-ERR-03`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-03",
    name: "Reserved error codes",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Error codes from 256 to 32767 are reserved and are not used.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "A later version of the specification may give the code a meaning. Clients would then show the \
          wrong problem.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[300]}}}"#
    ),
    fix: "Use a code below 256 from the specification, or a custom code of 32768 or above.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("A reserved error code is sent.", |out| out.set_in_state("errors", json!([300]))))
.mutants(&[Mutant::errors("the reserved code 300", &[300])]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let reserved = codes.iter().find(|code| (256..=32767).contains(*code))?;
        Some(format!("{reserved} is reserved"))
    });
}
