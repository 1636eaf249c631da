//! Pages. Error-code tables are laid out where that is safe; everywhere else white space goes from the ends
//! of lines, where it says nothing.

mod asciidoc;
mod line;
mod markdown;

use self::line::trimmed;
pub(super) use self::line::without_blank_end;
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
