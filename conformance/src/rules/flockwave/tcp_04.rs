//! `FW-TCP-04`.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, fw, served, tcp_02};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-TCP-04",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Over TCP half a message waits for the rest of it.",
        source: fw::DERIVED,
        applies_to: served::APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    covers: &[],
    bug: Bug::behaviour("Over TCP, the beginning of a message is forgotten that ends in another segment.")
        .with(&[&tcp_02::RULE.rule]),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
