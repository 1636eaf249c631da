//! `FW-TCP-02`.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, fw, served};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-TCP-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over TCP a message may come in several segments, and several in one.",
        source: fw::TRANSPORT,
        applies_to: served::APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    covers: &[],
    bug: Bug::behaviour("Over TCP, only the first of several requests in a segment is taken."),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
