//! Formatting of pages, which lays out simple error-code tables and removes trailing white space elsewhere.

mod asciidoc;
mod line;
mod markdown;

use uavspec_schema::table::{Form, Page};

use self::line::trimmed;
pub(super) use self::line::without_trailing_blank_lines;

/// Formats a page, which must be free of errors.
pub(super) fn lay_out(path: &str, written: &str, page: &Page) -> String {
    let text = written.replace("\r\n", "\n");
    if text.contains('\r') {
        // Parsers disagree on whether a lone carriage return ends a line, so the page is left unchanged.
        return written.to_owned();
    }
    let lines: Vec<&str> = text.split('\n').collect();
    let laid_out = match Form::of(path, &text) {
        Form::Markdown => markdown::lay_out(&text, &lines, page),
        Form::AsciiDoc => asciidoc::lay_out(written, &lines, page),
        Form::Flattened => lines.iter().map(|line| trimmed(line).to_owned() + "\n").collect(),
    };
    match without_trailing_blank_lines(&laid_out) {
        "" => String::new(),
        laid_out => laid_out.to_owned() + "\n",
    }
}
