//! `misplaced-annotation`: an annotation on a type that it says nothing about.

use super::rule::{Check, Levels, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "misplaced-annotation",
    purpose: "An annotation belongs to the type: units and ranges to numbers, patterns and formats to strings, lengths \
              to strings and lists. On any other it says nothing, and the value is not checked.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Rope\n\n| Field | Required | Type | Description |\n\
               |-------|----------|------|-------------|\n| name | yes | string | [@range 1, 8] Its name |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## Rope\n\n| Field | Required | Type | Description |\n\
               |-------|----------|------|-------------|\n| name | yes | string | [@length 1, 8] Its name |\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
