//! `PX-FMT-03`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-FMT-03",
    level: Level::Must,
    statement: "Each message has a field `timestamp` of type uint64.",
    source: "ULog file format, section on format messages",
    check: Check::Source,
};
