//! `misplaced-annotation`: an annotation that doesn't apply to the type.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "misplaced-annotation",
    statement: "An annotation that doesn't apply to the type of the value.",
    why: "The annotation has no effect, so the value is not checked. Units and ranges apply only to numbers. \
        Patterns and formats apply only to strings. Lengths apply only to strings and lists.",
    fix: "Use an annotation that applies to this type.",
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
