//! The formatter for definitions and for pages with error-code tables. The formatter maps text to text.
//!
//! Formatting never changes the meaning. Each result is parsed again. The source is left unchanged if formatting would
//! change the parsed model or a comment, or if formatting the result again would change it.

mod aligned;
mod comment;
mod meaning;
mod msg;
mod table;

use uavspec_schema::Form;
use uavspec_schema::diagnostic::{Diagnostic, has_errors};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::source::{SourceId, SourceMap};

/// The result of formatting a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formatted {
    /// The formatted text.
    pub text: String,
    /// True if the source was left unchanged because formatting would have changed its meaning. No known source causes
    /// this.
    pub is_kept: bool,
}

/// Formats the source `id`, which has the given `form`.
///
/// In `.msg`, `.srv` and `.action` files, declarations get single spaces, comments are aligned within each block of
/// lines, and consecutive blank lines are collapsed. Annotations move to the start of their comment, in a fixed order
/// and spelling.
///
/// In pages, the columns of error-code tables are aligned, and trailing white space is removed. Everything else stays
/// unchanged.
///
/// A source with errors is not formatted. The result then contains the diagnostics of the parser.
///
/// ```
/// use uavspec_schema::{Form, SourceMap, msg::Dialect};
/// use uavspec_lint::format::format;
///
/// let mut sources = SourceMap::default();
/// let id = sources.add("Wind.msg", "uint64   timestamp #[microseconds]Since start\r\n".into()).unwrap();
/// let formatted = format(&sources, id, Form::Msg(Dialect::Px4)).unwrap();
/// assert_eq!(formatted.text, "uint64 timestamp  # [us] Since start\n");
/// ```
pub fn format(sources: &SourceMap, id: SourceId, form: Form) -> Result<Formatted, Vec<Diagnostic>> {
    let source = read(sources, id, form)?;
    let unchanged = || Formatted { text: sources.text(id).to_owned(), is_kept: true };
    let mut again = SourceMap::default();
    let Ok(second) = again.add(sources.path(id), source.text.clone().into_bytes()) else {
        return Ok(unchanged());
    };
    let is_stable = read(&again, second, form)
        .is_ok_and(|second| second.meaning == source.meaning && second.text == source.text);
    Ok(if is_stable { Formatted { text: source.text, is_kept: false } } else { unchanged() })
}

/// One parsed source.
struct Reading {
    /// The formatted source.
    text: String,
    /// A description of the source's content, for comparison.
    meaning: Vec<String>,
}

fn read(sources: &SourceMap, id: SourceId, form: Form) -> Result<Reading, Vec<Diagnostic>> {
    match form {
        Form::Msg(dialect) => read_definition(sources, id, dialect),
        Form::Table => read_page(sources, id),
        // Event metadata is written by programs, so it needs no formatting.
        Form::Events => Ok(Reading { text: sources.text(id).to_owned(), meaning: Vec::new() }),
    }
}

fn read_definition(sources: &SourceMap, id: SourceId, dialect: Dialect) -> Result<Reading, Vec<Diagnostic>> {
    // A file with another extension is read as a message.
    let kind = Kind::of(sources.path(id)).unwrap_or(Kind::Message);
    let (definition, diagnostics) = uavspec_schema::msg::parse(sources, id, kind, dialect);
    if has_errors(&diagnostics) {
        return Err(diagnostics);
    }
    let text = msg::lay_out(sources, id, &definition, dialect);
    Ok(Reading { text, meaning: meaning::describe_definition(sources, &definition, dialect) })
}

fn read_page(sources: &SourceMap, id: SourceId) -> Result<Reading, Vec<Diagnostic>> {
    let (page, diagnostics) = uavspec_schema::table::parse(sources, id);
    if has_errors(&diagnostics) {
        return Err(diagnostics);
    }
    let text = table::lay_out(sources.path(id), sources.text(id), &page);
    Ok(Reading { text, meaning: meaning::describe_page(sources.path(id), sources.text(id), &page) })
}
