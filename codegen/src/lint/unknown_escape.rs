//! `unknown-escape`: a backslash in a string that starts no escape sequence.

use super::rule::{Check, Levels, Rule};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::example::Example;
use crate::finding::Edit;
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "unknown-escape",
    purpose: "A backslash in a quoted string starts an escape sequence, or is written twice. Where no sequence \
              starts, tools differ in what they read.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "ros2/GliderLog.msg",
        text: "# Where a glider keeps its log\n\nstring FOLDER = \"logs\\glider\"\n",
    },
    good: Example {
        path: "ros2/GliderLog.msg",
        text: "# Where a glider keeps its log\n\nstring FOLDER = \"logs\\\\glider\"\n",
    },
    measured: None,
    check: Check::Reader(fix),
};

/// As it is, the backslash stands for itself, which is what two of them say.
fn fix(diagnostic: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    match &diagnostic.problem {
        Problem::UnknownEscape { escape } => {
            vec![Edit { span: diagnostic.span, text: format!("\\{escape}") }]
        }
        _ => Vec::new(),
    }
}
