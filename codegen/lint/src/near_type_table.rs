//! `near-type-table`: a table that is almost a type table.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "near-type-table",
    statement: "A table whose columns almost match those of a type table.",
    why: "If a column is missing or misspelt, the table is treated as text and defines no fields.",
    fix: "Correct the columns: `Field`, `Required`, `Type`, `Description`.",
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
