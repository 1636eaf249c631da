//! `FW-ENV-21`.

use super::served::{self, APPLIES_TO};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-21",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A request whose id is unusual but allowed is answered, and the answer has that id: 36 characters, letters that aren't ASCII, spaces.",
        source: fw::DERIVED,
        applies_to: APPLIES_TO,
    },
    check: Check::Exchange(served::check),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || fw::unanswered("tcp#9", RULE.rule.id), also: &[] },
        Mutant { name: served::REFUSED, make: || fw::refused("tcp#9", RULE.rule.id), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(RULE.rule.id), also: &[] },
    ],
};
