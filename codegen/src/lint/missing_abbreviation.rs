//! `missing-abbreviation`: an error code without an abbreviation.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "missing-abbreviation",
    purpose: "An error code has an abbreviation, or a `-` that says that none is meant. User interfaces show \
              it where space is short, and the bare number where there is none.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 64 | | The rope is worn. |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 64 | ROPE | The rope is worn. |\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
