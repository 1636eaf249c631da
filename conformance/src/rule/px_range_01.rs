//! `PX-RANGE-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-RANGE-01",
    level: Level::Should,
    statement: "A value lies in its range, unless it is the one that says that there is no data.",
    source: "`@range` and `@invalid` of the definition",
    check: Check::Value,
};
