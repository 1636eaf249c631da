//! `missing-abbreviation`: an error code without an abbreviation.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "missing-abbreviation",
    statement: "An error code without an abbreviation.",
    why: "User interfaces show the abbreviation if there is little space. Without an abbreviation, they show the \
        number.",
    fix: "Add an abbreviation, or `-` if the code should have none.",
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
