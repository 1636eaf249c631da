//! `PX-JSON-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-JSON-01",
    level: Level::Must,
    statement: "A message in JSON has exactly the fields of its definition: none is missing, unknown or there twice.",
    source: "the fields of the definition; the published JSON Schema",
    check: Check::Value,
};
