//! `PX-NAN-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-NAN-01",
    level: Level::Should,
    statement: "NaN stands only where the definition gives it a meaning; so in fields that it restricts.",
    source: "`@invalid NaN` of the definition, or its text",
    check: Check::Value,
};
