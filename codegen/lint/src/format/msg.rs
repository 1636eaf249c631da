//! Formatting of `.msg`, `.srv` and `.action` files.

use std::fmt::Write as _;

use uavspec_schema::msg::ast::{Comment, Definition, Item, Line};
use uavspec_schema::msg::{Dialect, is_separator};
use uavspec_schema::source::{SourceId, SourceMap};

use super::aligned::ALIGNED_WITHIN;
use super::comment;

/// The start of a comment that lists topics, without the `#`.
const TOPICS: &str = " TOPICS ";

/// The characters that separate words.
const SPACES: [char; 2] = [' ', '\t'];

/// A formatted line, before its comment is aligned.
enum Row {
    Blank,
    /// `---`, or a comment on a separate line. Both end a block.
    Apart(String),
    /// A list of topics or a directive, neither of which ends a block.
    Aside(String),
    Declared {
        declaration: String,
        comment: Option<String>,
    },
    /// A comment that continues the comment of the declaration above.
    Continued(String),
}

/// Formats a definition, which must be free of errors.
pub(super) fn lay_out(
    sources: &SourceMap,
    id: SourceId,
    definition: &Definition<'_>,
    dialect: Dialect,
) -> String {
    let rows = tidy(rows(sources, id, definition, dialect));
    let mut text = String::with_capacity(sources.text(id).len());
    let ends_block = |row: &Row| matches!(row, Row::Blank | Row::Apart(_));
    for block in rows.chunk_by(|first, second| !ends_block(first) && !ends_block(second)) {
        print(block, &mut text);
    }
    text
}

fn rows(sources: &SourceMap, id: SourceId, definition: &Definition<'_>, dialect: Dialect) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut parts = definition.parts.iter();
    let mut reader = Reader { sources, dialect, is_after_declaration: false };
    let mut lines = parts.next().map_or(&[][..], |part| &part.lines).iter();
    // The syntax tree does not contain the separator lines between parts.
    for written in sources.text(id).split_inclusive('\n') {
        if is_separator(written.trim_end_matches(['\n', '\r'])) {
            push_separator(written, &mut rows);
            reader.is_after_declaration = false;
            lines = parts.next().map_or(&[][..], |part| &part.lines).iter();
        } else if let Some(line) = lines.next() {
            rows.push(reader.row(line));
        }
    }
    rows
}

/// Adds a separator. Its comment moves to the end of the part above, because rosidl rejects text after `---`. The blank
/// line keeps the moved comment from becoming the comment of the part.
fn push_separator(line: &str, rows: &mut Vec<Row>) {
    if let Some((_, text)) = line.split_once('#') {
        rows.push(Row::Blank);
        rows.push(Row::Apart(comment::standalone(text.trim_end())));
    }
    rows.push(Row::Apart("---".to_owned()));
}

/// Formats lines in order, and tracks the state that determines how comments are interpreted.
struct Reader<'m> {
    sources: &'m SourceMap,
    dialect: Dialect,
    /// True if an indented comment on the next line would continue the comment of a declaration.
    is_after_declaration: bool,
}

impl<'m> Reader<'m> {
    fn row(&mut self, line: &Line<'_>) -> Row {
        match (line.item.as_deref(), line.comment.as_deref()) {
            (Some(item), comment) => {
                self.is_after_declaration = true;
                self.declared(line, item, comment)
            }
            (None, Some(comment)) => self.standalone(comment, self.written(line, comment)),
            (None, None) => {
                self.is_after_declaration = false;
                Row::Blank
            }
        }
    }

    /// The text after the `#` of a comment, up to the end of the line.
    fn written(&self, line: &Line<'_>, comment: &Comment<'_>) -> &'m str {
        self.sources.slice(line.span).get(comment.column + 1..).unwrap_or("").trim_end()
    }

    fn declared(&self, line: &Line<'_>, item: &Item<'_>, comment: Option<&Comment<'_>>) -> Row {
        let written = self.sources.slice(line.span);
        let end = comment.map_or(written.len(), |comment| comment.column);
        let after = |position: u32| {
            let rest = written.get((position - line.span.start) as usize..end).unwrap_or("");
            rest.trim_start_matches(SPACES).trim_end()
        };
        let name = match item {
            Item::Field(field) => &field.name,
            Item::Constant(constant) => &constant.name,
        };
        let ty = written.trim_start_matches(SPACES).split(SPACES).next().unwrap_or("");
        let mut declaration = format!("{ty} {}", name.text);
        let value = match item {
            Item::Field(_) => after(name.span.end),
            Item::Constant(constant) => {
                declaration.push_str(" =");
                self.sources.slice(constant.value_span)
            }
        };
        if !value.is_empty() {
            declaration.push(' ');
            declaration.push_str(value);
        }
        let is_constant = matches!(item, Item::Constant(_));
        let comment = comment.map(|comment| comment::trailing(self.written(line, comment), is_constant));
        Row::Declared { declaration, comment }
    }

    /// Formats a comment on a separate line. `written` is the text after the `#`. The result lists topics only if the
    /// original does.
    fn standalone(&mut self, comment: &Comment<'_>, written: &str) -> Row {
        let topics = comment.text.strip_prefix(TOPICS).filter(|_| self.dialect == Dialect::Px4);
        let is_indented = comment.column > 0;
        match topics {
            Some(topics) if !is_indented => {
                let (_, directive) = comment::split_directive(written);
                let words = topics.split(SPACES).chain([directive]).filter(|word| !word.is_empty());
                return Row::Aside(words.fold("# TOPICS".to_owned(), |line, word| line + " " + word));
            }
            _ if self.is_after_declaration && is_indented => {
                return Row::Continued(comment::continued(written));
            }
            _ if comment.is_directive() => return Row::Aside(comment::standalone(written)),
            _ => self.is_after_declaration = false,
        }
        let laid_out = comment::standalone(written);
        Row::Apart(match topics {
            Some(_) => format!(" {laid_out}"),
            None if self.dialect == Dialect::Px4 && laid_out[1..].starts_with(TOPICS) => {
                format!("#{written}")
            }
            None => laid_out,
        })
    }
}

/// Removes trailing blank lines and collapses consecutive blank lines. A blank line at the start is kept only before a
/// comment, which would otherwise become the comment of the whole definition.
fn tidy(rows: Vec<Row>) -> Vec<Row> {
    let mut tidy: Vec<Row> = Vec::with_capacity(rows.len());
    for row in rows {
        let is_after_blank = matches!(tidy.last(), Some(Row::Blank));
        if is_after_blank && matches!(row, Row::Blank) {
            continue;
        }
        if is_after_blank && tidy.len() == 1 && !is_comment(&row) {
            tidy.clear();
        }
        tidy.push(row);
    }
    if matches!(tidy.last(), Some(Row::Blank)) {
        tidy.pop();
    }
    tidy
}

fn is_comment(row: &Row) -> bool {
    match row {
        Row::Apart(line) => line.trim_start().starts_with('#'),
        Row::Aside(_) => true,
        Row::Blank | Row::Declared { .. } | Row::Continued(_) => false,
    }
}

/// Writes the lines of a block with aligned comments.
fn print(block: &[Row], text: &mut String) {
    let widths = block.iter().filter_map(|row| match row {
        Row::Declared { declaration, .. } => Some(declaration.chars().count()),
        _ => None,
    });
    let widest = widths.filter(|width| *width <= ALIGNED_WITHIN).max().unwrap_or(0);
    for row in block {
        match row {
            Row::Blank => {}
            Row::Apart(line) | Row::Aside(line) => text.push_str(line),
            Row::Declared { declaration, comment: None } => text.push_str(declaration),
            Row::Declared { declaration, comment: Some(comment) } => {
                let _ = write!(text, "{declaration:widest$}  {comment}");
            }
            Row::Continued(comment) => {
                let _ = write!(text, "{:widest$}  {comment}", "");
            }
        }
        text.push('\n');
    }
}
