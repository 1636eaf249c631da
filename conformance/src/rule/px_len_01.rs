//! `PX-LEN-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-LEN-01",
    level: Level::Must,
    statement: "A count of entries in use is at most the length of the array that it counts.",
    source: "`@count` of the definition, or the names `num_x` and `x_count`",
    check: Check::Value,
};
