//! `PX-DATA-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-DATA-01",
    level: Level::Must,
    statement: "A payload has the full size of its format, or the full size less the padding at its end.",
    source: "the format in the log, and PX4's logger",
    check: Check::Source,
};
