//! `FW-TCP-03`.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, fw, served};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-TCP-03",
        level: Level::Should,
        status: Status::Normative,
        statement: "Over TCP a line that is no JSON is passed over, and the next one is served.",
        source: fw::TRANSPORT,
        applies_to: served::APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    covers: &[],
    bug: Bug::behaviour("Over TCP, a line that is no JSON ends the connection."),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
