//! `FW-ERR-06`.

use std::collections::HashSet;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-06",
    name: "No repeated error codes",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The list of errors contains each code at most once.",
    source: source::DERIVED,
    applies_to: "`errors` of UAV-INF",
    why: "Clients that show one line per entry show the problem twice and count too many problems.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[64,64]}}}"#
    ),
    fix: "Collect the active codes in a set before you send them.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("An error code is sent twice.", |out| out.set_in_state("errors", json!([64, 64]))))
.mutants(&[Mutant::errors("a duplicate code", &[1, 1])]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let mut seen = HashSet::new();
        let duplicate = codes.iter().find(|code| !seen.insert(**code))?;
        Some(format!("{duplicate} is listed twice"))
    });
}
