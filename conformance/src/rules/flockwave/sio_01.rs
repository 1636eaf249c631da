//! `FW-SIO-01`.

use super::served::{self, APPLIES_TO};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over Socket.IO connections are upgraded and opened as its protocol says, and messages travel as events `fw`.",
        source: fw::TRANSPORT,
        applies_to: APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("socketio#9", RULE.rule.id), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("socketio#9", RULE.rule.id), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(RULE.rule.id), also: &[] },
    ],
};
