//! Pages. Error-code tables are laid out where that is safe; everywhere else white space goes from the ends
//! of lines, where it says nothing.

mod asciidoc;
mod markdown;

use crate::table::{Form, Page};

/// The page laid out; it has no mistakes.
pub(super) fn lay_out(path: &str, written: &str, page: &Page) -> String {
    let text = written.replace("\r\n", "\n");
    if text.contains('\r') {
        // Alone it ends a line for some and not for others: who knows what the page says.
        return written.to_owned();
    }
    let lines: Vec<&str> = text.split('\n').collect();
    let laid_out = match Form::of(path, &text) {
        Form::Markdown => markdown::lay_out(&text, &lines, page),
        Form::AsciiDoc => asciidoc::lay_out(written, &lines, page),
        Form::Flattened => lines.iter().map(|line| trimmed(line).to_owned() + "\n").collect(),
    };
    match without_blank_end(&laid_out) {
        "" => String::new(),
        laid_out => laid_out.to_owned() + "\n",
    }
}

/// The text up to the end of its last line that isn't blank.
pub(super) fn without_blank_end(text: &str) -> &str {
    let end = text.trim_end_matches([' ', '\t', '\r', '\n']).len();
    let line = text[end..].find(['\r', '\n']).map_or(text.len(), |len| end + len);
    if end == 0 { "" } else { &text[..line] }
}

/// The line without white space at its end, unless that says something: after a backslash, that the line doesn't
/// break there; after three dashes, that they enclose no front matter.
fn trimmed(line: &str) -> &str {
    let trimmed = line.trim_end_matches([' ', '\t']);
    if trimmed.ends_with('\\') || trimmed == "---" { line } else { trimmed }
}

/// Where each line starts.
fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect()
}

/// The line, from 0, that holds the position `at`.
fn line_of(starts: &[usize], at: usize) -> usize {
    starts.partition_point(|start| *start <= at).saturating_sub(1)
}
