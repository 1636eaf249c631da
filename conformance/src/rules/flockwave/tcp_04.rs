//! `FW-TCP-04`.

use std::time::Duration;

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Rule, Sent, Status, Step, Strain, Trial, mutant,
    served, source, tcp_02,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-TCP-04",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Over TCP half a message waits for the rest of it.",
        source: source::DERIVED,
        applies_to: served::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(served::check)],
    covers: &[],
    bug: Bug::behaviour("Over TCP, the beginning of a message is forgotten that ends in another segment.")
        .with(&[&tcp_02::RULE.rule]),
    trial: Some(Trial::Attempts(Strain::Sound, attempts)),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || mutant::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};

/// The pause after which a server may think that nothing follows.
const LONG_PAUSE: Duration = Duration::from_millis(1_200);

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::Tcp(_)) {
        return Vec::new();
    }
    let late = Step::Pieces(Sent::request("one", "SYS-VER"), 2, LONG_PAUSE);
    vec![Attempt::new("a message whose second half comes late", [late])]
}
