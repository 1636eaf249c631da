//! `FW-ERR-04`.

use std::ops::RangeInclusive;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-04",
    name: "Defined error codes",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Each error code below 256 is defined in the specification.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "Clients have no text for an undefined code. The operator sees a bare number, or nothing.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[50]}}}"#
    ),
    fix: "Replace the code with the matching one in the specification. If none fits, use 127, 191 or 255, \
          or a custom code of 32768 or above.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("An undefined error code is sent.", |out| out.set_in_state("errors", json!([50]))))
.mutants(&[Mutant::errors("the undefined code 12", &[12])]);

/// The defined codes, except 0.
const KNOWN: [RangeInclusive<i128>; 9] =
    [1..=11, 63..=63, 64..=75, 127..=127, 128..=142, 188..=191, 192..=207, 253..=254, 255..=255];

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let is_known =
            |code: &i128| !(1..=255).contains(code) || KNOWN.iter().any(|known| known.contains(code));
        let unknown = codes.iter().find(|code| !is_known(code))?;
        Some(format!("the specification does not define code {unknown}"))
    });
}
