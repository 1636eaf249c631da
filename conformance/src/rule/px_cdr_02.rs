//! `PX-CDR-02`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-CDR-02",
    level: Level::Must,
    statement: "A CDR payload holds its message whole and nothing more but what fills it up to a multiple of four bytes; sequences and strings keep their bounds, and strings end with their NUL.",
    source: "DDS-XTypes 1.3, section 7.4; the types of the definition",
    check: Check::Source,
};
