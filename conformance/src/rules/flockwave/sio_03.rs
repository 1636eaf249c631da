//! `FW-SIO-03`.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, fw, served};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "An event that isn't `fw`, or whose argument is no message, doesn't end the service.",
        source: fw::DERIVED,
        applies_to: served::APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    covers: &[],
    bug: Bug::behaviour(
        "Over Socket.IO, nothing is answered any more after an event that is none of Flockwave.",
    )
    .needs(Needs::SocketIo),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
