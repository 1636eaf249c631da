//! `FW-UDP-03`.

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, Strain, Trial, mutant, source,
    trial, udp,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UDP-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A datagram that is no message doesn't end the service.",
        source: source::DERIVED,
        applies_to: udp::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(udp::Trials::if_server_sends()))],
    covers: &[],
    bug: Bug::behaviour("Over UDP, a datagram that is no JSON ends the service.").needs(Needs::Udp),
    trial: Some(Trial::Attempts(Strain::Noise, attempts)),
    mutants: &[
        Mutant { name: "trials without an answer", make: || udp::unanswered(&RULE.rule), also: &[] },
        Mutant { name: "a trial that is refused", make: || mutant::refused("udp#9", &RULE.rule), also: &[] },
    ],
};

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::Udp(_) => trial::after_noise("after a datagram that is no JSON", &udp::REQUESTS),
        _ => Vec::new(),
    }
}
