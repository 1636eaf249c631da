//! `description-missing`: an error code that nobody explains.

use super::rule::{Check, Levels, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Package;
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "description-missing",
    purpose: "An error code has a description. An operator who sees the code has to know what has happened and \
              what to do.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 64 | ROPE | |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 64 | ROPE | The rope is worn. |\n",
    },
    measured: None,
    check: Check::ErrorCodes(check),
};

fn check(package: &Package, _: &SourceMap, sink: &mut Sink<'_>) {
    for code in package.error_tables.iter().flat_map(|table| &table.codes) {
        if code.description.trim_matches(['-', '–', '—', '.', ' ']).is_empty() {
            sink.report(
                code.span,
                format!("code {} has no description", code.code),
                "say what has happened, and what to do about it",
            );
        }
    }
}
