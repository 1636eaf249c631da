//! `PX-FMT-02`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-FMT-02",
    level: Level::Must,
    statement: "Each type that a format nests has a format in the same log.",
    source: "ULog file format, section on format messages",
    check: Check::Source,
};
