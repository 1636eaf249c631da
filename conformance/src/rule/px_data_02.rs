//! `PX-DATA-02`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-DATA-02",
    level: Level::Must,
    statement: "Each payload belongs to a subscription that was made before it.",
    source: "ULog file format, section on data messages",
    check: Check::Source,
};
