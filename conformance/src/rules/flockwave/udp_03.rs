//! `FW-UDP-03`.

use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw, udp};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UDP-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A datagram that is no message doesn't end the service.",
        source: fw::DERIVED,
        applies_to: udp::APPLIES_TO,
    },
    check: Check::State(|| Box::new(udp::Trials::once_heard())),
    mutants: &[
        Mutant { name: "trials without an answer", make: || udp::unanswered(RULE.rule.id), also: &[] },
        Mutant { name: "a trial that is refused", make: || fw::refused("udp#9", RULE.rule.id), also: &[] },
    ],
};
