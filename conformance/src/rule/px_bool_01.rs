//! `PX-BOOL-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-BOOL-01",
    level: Level::Must,
    statement: "A byte of a bool is 0 or 1.",
    source: "`bool` of the definition; PX4 copies the byte from memory",
    check: Check::Value,
};
