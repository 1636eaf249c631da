//! `PX-ENUM-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-ENUM-01",
    level: Level::Should,
    statement: "A field with an `@enum` holds a documented constant, one with `@flags` a mask of them.",
    source: "`@enum` and `@flags` of the definition",
    check: Check::Value,
};
