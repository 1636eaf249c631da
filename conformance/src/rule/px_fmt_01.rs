//! `PX-FMT-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-FMT-01",
    level: Level::Info,
    statement: "A format that a log brings equals the definition: fields, order, types, lengths of arrays, padding. Logs of other firmware differ without being wrong, so this is shown and judged only with `--strict-formats`.",
    source: "the definition",
    check: Check::Source,
};
