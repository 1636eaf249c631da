//! `unknown-escape`: a string with a backslash that starts no escape sequence.

use uavspec_schema::diagnostic::Problem;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "unknown-escape",
    statement: "A string with a backslash that does not start an escape sequence.",
    why: "Different tools interpret the backslash differently.",
    fix: "Write two backslashes.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "ros2/GliderLog.msg",
        text: "# Log folder of a glider\n\nstring FOLDER = \"logs\\glider\"\n",
    },
    good: Example {
        path: "ros2/GliderLog.msg",
        text: "# Log folder of a glider\n\nstring FOLDER = \"logs\\\\glider\"\n",
    },
    measured: None,
    check: Check::Reader(fix),
};

/// Doubles the backslash, so that the string keeps its current meaning.
fn fix(diagnostic: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    match &diagnostic.problem {
        Problem::UnknownEscape { escape } => {
            vec![Edit { span: diagnostic.span, text: format!("\\{escape}") }]
        }
        _ => Vec::new(),
    }
}
