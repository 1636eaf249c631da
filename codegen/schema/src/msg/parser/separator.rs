//! The lines that separate the parts of a service or action.

use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::kind::Kind;
use crate::source::Span;

/// The reference parser of ROS 2.
pub(super) const ROSIDL: &str = "rosidl";

/// A separator as ROS 2 requires it.
const SEPARATOR: &str = "---";

/// Hyphens, and the dashes that word processors write instead of several hyphens.
const DASHES: [char; 3] = ['-', '\u{2013}', '\u{2014}'];

/// True for `---`, optionally followed by spaces and a comment.
pub fn is_separator(line: &str) -> bool {
    line.strip_prefix(SEPARATOR).is_some_and(|rest| {
        let rest = rest.trim_start_matches([' ', '\t']);
        rest.is_empty() || rest.starts_with('#')
    })
}

/// Reports text after a separator. rosidl compares the whole line with `---`.
pub(super) fn check(line: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) {
    if line == SEPARATOR {
        return;
    }
    let has_comment = line.contains('#');
    let problem = Problem::NotPortable {
        tool: ROSIDL,
        text: line.to_owned(),
        instead: (!has_comment).then(|| SEPARATOR.to_owned()),
    };
    let hint =
        if has_comment { "move the comment to a separate line" } else { "remove the spaces after `---`" };
    diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
}

/// The error in a line of dashes that is not a separator, such as `----` or `- - -`.
pub(super) fn invalid(line: &str, span: Span, kind: Kind) -> Option<Diagnostic> {
    let text = line.split('#').next().unwrap_or(line).trim_matches([' ', '\t']);
    let dashes = text.chars().filter(|c| DASHES.contains(c)).count();
    let is_drawn = dashes > 0 && text.chars().all(|c| DASHES.contains(&c) || c == ' ');
    if !is_drawn || is_separator(line) {
        return None;
    }
    let diagnostic = Diagnostic::new(Problem::InvalidSeparator { text: text.to_owned() }, span);
    Some(match kind {
        Kind::Message => diagnostic.with_hint("start a comment with `#`; a .msg file has no parts"),
        Kind::Service | Kind::Action if text == SEPARATOR => {
            diagnostic.with_hint("remove the spaces before `---`")
        }
        Kind::Service | Kind::Action => diagnostic,
    })
}
