//! `FW-SIO-01`.

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, Step, Strain, Trial, mutant,
    served, source,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over Socket.IO connections are upgraded and opened as its protocol says, and messages travel as events `fw`.",
        source: source::TRANSPORT,
        applies_to: served::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(served::check)],
    covers: &[],
    bug: Bug::behaviour("Over Socket.IO, messages travel as events flockwave.").needs(Needs::SocketIo),
    trial: Some(Trial::Attempts(Strain::Sound, attempts)),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || mutant::unanswered("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || mutant::refused("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::SocketIo { .. } => vec![Attempt::new("", [Step::request("one")])],
        _ => Vec::new(),
    }
}
