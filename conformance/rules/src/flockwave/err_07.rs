//! `FW-ERR-07`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-07",
    name: "One of several alternative codes",
    level: Level::Should,
    status: Status::DisputedCases(
        "The specification text for code 65 names 131 as the alternative, but 131 is unrelated. This rule \
         uses 132.",
    ),
    statement: "Alternative codes for the same condition are not listed together. The groups of \
                alternatives are 65 and 132; 66, 134 and 199; 133 and 197; 71 and 201; 72 and 139.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "Alternative codes report the same condition at different severities. If both are sent, the \
          operator does not know whether the UAV can continue or has to land.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[66,134]}}}"#
    ),
    fix: "Send only the code that matches the current severity, and replace it when the severity changes.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Two low-battery codes are sent together.", |out| {
    out.set_in_state("errors", json!([66, 134]));
}))
.mutants(&[
    Mutant::errors("two low-battery codes", &[66, 134]),
    Mutant::errors("two geofence codes", &[71, 201]),
    Mutant::errors("a disputed pair of codes", &[65, 132]),
]);

/// The code for which the specification contradicts itself about the alternative.
const DISPUTED: i128 = 65;

const ALTERNATIVES: [&[i128]; 5] = [&[65, 132], &[66, 134, 199], &[133, 197], &[71, 201], &[72, 139]];

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    body::codes(message, context, |codes| {
        let conflict = ALTERNATIVES.iter().find_map(|group| {
            let mut found = group.iter().filter(|code| codes.contains(code));
            found.next().zip(found.next())
        });
        conflict.map(|(one, other)| {
            Detail::new(format!("{one} and {other} are alternatives")).disputed(*one == DISPUTED)
        })
    });
}
