//! Pages. Only the error-code tables of Markdown are laid out; everywhere else white space goes from the ends
//! of lines, where it says nothing.

mod markdown;

use crate::table::{Form, Page};

/// The page laid out; it has no mistakes.
pub(super) fn lay_out(path: &str, text: &str, page: &Page) -> String {
    // Lines keep their number, and their ends are found where they were.
    let text = text.replace("\r\n", "\n");
    let laid_out = match Form::of(path, &text) {
        Form::Markdown => markdown::lay_out(&text, page),
        Form::AsciiDoc | Form::Flattened => {
            text.split('\n').map(|line| trimmed(line).to_owned() + "\n").collect()
        }
    };
    match laid_out.trim_end_matches(['\n', ' ', '\t']) {
        "" => String::new(),
        laid_out => laid_out.to_owned() + "\n",
    }
}

/// The line without white space at its end. After a backslash that says that the line doesn't break there.
fn trimmed(line: &str) -> &str {
    let trimmed = line.trim_end_matches([' ', '\t']);
    if trimmed.ends_with('\\') { line } else { trimmed }
}
