//! `PX-STR-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-STR-01",
    level: Level::Should,
    statement: "Text in a `char` array is UTF-8 up to its first NUL.",
    source: "`char[N]` of the definition",
    check: Check::Value,
};
