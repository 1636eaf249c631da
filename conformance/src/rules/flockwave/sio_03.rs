//! `FW-SIO-03`.

use super::served::{self, APPLIES_TO};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "An event that isn't `fw`, or whose argument is no message, doesn't end the service.",
        source: fw::DERIVED,
        applies_to: APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("socketio#9", RULE.rule.id), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("socketio#9", RULE.rule.id), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(RULE.rule.id), also: &[] },
    ],
};
