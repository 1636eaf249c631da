//! `near-type-table`: a table that is nearly one of a type.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "near-type-table",
    purpose: "A table defines a type where its columns are those of one. Where a column is missing or misspelt, it stays \
              prose, and nobody is told of its fields.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Rope\n\n| Field | Requried | Type |\n\
               |-------|----------|------|\n| name | yes | string |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## Rope\n\n| Field | Required | Type | Description |\n\
               |-------|----------|------|-------------|\n| name | yes | string | Its name |\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
