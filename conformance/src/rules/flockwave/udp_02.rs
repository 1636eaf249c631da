//! `FW-UDP-02`.

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, Step, Strain, Trial, mutant,
    source, udp,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UDP-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The answer goes to the address and port that the request came from.",
        source: source::DERIVED,
        applies_to: udp::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(udp::Trials::new()))],
    covers: &[],
    bug: Bug::behaviour("Over UDP, answers go to the port after that of the sender.").needs(Needs::Udp),
    trial: Some(Trial::Attempts(Strain::Sound, attempts)),
    mutants: &[
        Mutant { name: "trials without an answer", make: || udp::unanswered(&RULE.rule), also: &[] },
        Mutant { name: "a trial that is refused", make: || mutant::refused("udp#9", &RULE.rule), also: &[] },
    ],
};

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::Udp(_) => vec![Attempt::new("", udp::REQUESTS.map(Step::request))],
        _ => Vec::new(),
    }
}
