//! The one layout of definitions and of pages with error-code tables: text in, text out.
//!
//! What a source says stays as it is: each result is read again, and where the model, a comment or a second
//! run would differ, the source is kept as it was written.

mod aligned;
mod comment;
mod meaning;
mod msg;
mod table;

use crate::diagnostic::{Diagnostic, has_errors};
use crate::msg::{Dialect, Kind};
use crate::schema::Form;
use crate::source::{SourceId, SourceMap};

/// A source in its layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formatted {
    /// The whole text.
    pub text: String,
    /// Whether the text is kept as it was, since the layout would have changed what it says. No source is
    /// known that is.
    pub is_kept: bool,
}

/// Lays out the source `id`, which is written in `form`.
///
/// In `.msg` files and their relatives: declarations with single blanks, comments aligned in each block of
/// lines, annotations at the head of a comment in one order and spelling, one blank line where there were
/// several. In pages: the columns of error-code tables; of the rest only white space at the ends of lines. A
/// source with mistakes is not laid out: the diagnostics are all that the parser says of it.
///
/// ```
/// use uavspec_codegen::{SourceMap, format::format, msg::Dialect, schema::Form};
///
/// let mut sources = SourceMap::default();
/// let id = sources.add("Wind.msg", "uint64   timestamp #[microseconds]Since start\r\n".into()).unwrap();
/// let formatted = format(&sources, id, Form::Msg(Dialect::Px4)).unwrap();
/// assert_eq!(formatted.text, "uint64 timestamp  # [us] Since start\n");
/// ```
pub fn format(sources: &SourceMap, id: SourceId, form: Form) -> Result<Formatted, Vec<Diagnostic>> {
    let source = read(sources, id, form)?;
    let kept = || Formatted { text: sources.text(id).to_owned(), is_kept: true };
    let mut again = SourceMap::default();
    let Ok(second) = again.add(sources.path(id), source.text.clone().into_bytes()) else { return Ok(kept()) };
    let is_same = read(&again, second, form)
        .is_ok_and(|second| second.meaning == source.meaning && second.text == source.text);
    Ok(if is_same { Formatted { text: source.text, is_kept: false } } else { kept() })
}

/// What one reading of a source gives.
struct Reading {
    /// The source laid out.
    text: String,
    /// What it says.
    meaning: Vec<String>,
}

fn read(sources: &SourceMap, id: SourceId, form: Form) -> Result<Reading, Vec<Diagnostic>> {
    match form {
        Form::Msg(dialect) => read_definition(sources, id, dialect),
        Form::Table => read_page(sources, id),
    }
}

fn read_definition(sources: &SourceMap, id: SourceId, dialect: Dialect) -> Result<Reading, Vec<Diagnostic>> {
    // By any other name it is read as a message.
    let kind = Kind::of(sources.path(id)).unwrap_or(Kind::Message);
    let (definition, diagnostics) = crate::msg::parse(sources, id, kind, dialect);
    if has_errors(&diagnostics) {
        return Err(diagnostics);
    }
    let text = msg::lay_out(sources, id, &definition, dialect);
    Ok(Reading { text, meaning: meaning::of_definition(sources, &definition, dialect) })
}

fn read_page(sources: &SourceMap, id: SourceId) -> Result<Reading, Vec<Diagnostic>> {
    let (page, diagnostics) = crate::table::parse(sources, id);
    if has_errors(&diagnostics) {
        return Err(diagnostics);
    }
    let text = table::lay_out(sources.path(id), sources.text(id), &page);
    Ok(Reading { text, meaning: meaning::of_page(sources.path(id), sources.text(id), &page) })
}
