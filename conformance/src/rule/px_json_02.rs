//! `PX-JSON-02`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-JSON-02",
    level: Level::Must,
    statement: "Each value in JSON has the JSON type of its field and lies in the range of its type; a float that is NaN is null, infinity can't be said.",
    source: "the type of the definition; RFC 8259 for numbers",
    check: Check::Value,
};
