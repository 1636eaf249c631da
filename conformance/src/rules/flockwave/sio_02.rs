//! `FW-SIO-02`.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, fw, served};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over Socket.IO messages also travel by long polling.",
        source: fw::TRANSPORT,
        applies_to: served::APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    covers: &[],
    bug: Bug::behaviour("Over Socket.IO, long polling is refused.").needs(Needs::SocketIo),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
