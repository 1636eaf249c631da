//! `PX-ARR-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-ARR-01",
    level: Level::Must,
    statement: "In JSON an array has its defined length, and a sequence, a string or the text of a `char` array keeps its bound.",
    source: "the type of the definition, `T[N]`, `T[<=N]`, `string<=N`, `char[N]`",
    check: Check::Value,
};
