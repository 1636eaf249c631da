//! `one-sided-alternative`: error codes that don't name each other as alternatives.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "one-sided-alternative",
    statement: "An error code that lists an alternative, but is not listed by that alternative.",
    why: "Only one of the two codes may be reported for an event. A developer who reads only the \
        alternative's description may report both codes.",
    fix: "Mention each code in the description of the other.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n\
               | 64 | ROPE | The rope is worn. Use this code only if it holds; otherwise use code 65. |\n\
               | 65 | ROPE2 | The rope is torn. |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n\
               | 64 | ROPE | The rope is worn. Use this code only if it holds; otherwise use code 65. |\n\
               | 65 | ROPE2 | The rope is torn. Use this code only if it doesn't hold; otherwise use code 64. |\n",
    },
    measured: None,
    check: Check::Reader(no_fix),
};
