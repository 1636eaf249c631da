//! `FW-UDP-02`.

use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw, udp};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UDP-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The answer goes to the address and port that the request came from.",
        source: fw::DERIVED,
        applies_to: udp::APPLIES_TO,
    },
    check: Check::State(|| Box::new(udp::Trials::new())),
    mutants: &[
        Mutant { name: "trials without an answer", make: || udp::unanswered(RULE.rule.id), also: &[] },
        Mutant { name: "a trial that is refused", make: || fw::refused("udp#9", RULE.rule.id), also: &[] },
    ],
};
