//! The format-independent page.

use super::text::Text;
use crate::source::Span;

/// The headings, tables and paragraphs of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The whole page.
    pub span: Span,
    /// The headings in order, with their levels.
    pub headings: Vec<Heading>,
    /// The tables in order.
    pub tables: Vec<Table>,
    /// The paragraphs in order, except paragraphs in lists and quotations. Empty for a flattened page, which doesn't
    /// preserve paragraphs.
    pub paragraphs: Vec<Paragraph>,
}

impl Page {
    pub(super) fn new(span: Span) -> Self {
        Self { span, headings: Vec::new(), tables: Vec::new(), paragraphs: Vec::new() }
    }

    /// The nearest heading above `table`.
    pub fn heading(&self, table: &Table) -> Option<&Heading> {
        self.headings.get(table.heading?)
    }
}

/// A heading.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// The level: 1 for the title of a page, 2 for sections, and so on. Always 1 in the flattened form.
    pub level: usize,
    /// The text.
    pub text: Text,
}

/// A paragraph.
#[derive(Clone, Debug, PartialEq)]
pub struct Paragraph {
    /// The index of the nearest heading above.
    pub heading: Option<usize>,
    /// The text.
    pub text: Text,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The index of the nearest heading above.
    pub heading: Option<usize>,
    /// The title of the table (`AsciiDoc` only).
    pub title: Option<Text>,
    /// The cells of the first row.
    pub header: Vec<Cell>,
    /// The other rows.
    pub rows: Vec<Row>,
    /// The start of the table: its header or opening line.
    pub span: Span,
}

/// A row as written. A row may have more or fewer cells than the header.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The cells.
    pub cells: Vec<Cell>,
    /// The range from the first to the last cell.
    pub span: Span,
}

impl Row {
    pub(super) fn new(cells: Vec<Cell>, page: Span) -> Self {
        let span = match (cells.first(), cells.last()) {
            (Some(first), Some(last)) => first.text.span().to(last.text.span()),
            _ => page.part(0..0),
        };
        Self { cells, span }
    }
}

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The text without markup.
    pub text: Text,
    /// True for a merged or repeated cell (`AsciiDoc` only).
    pub is_merged: bool,
}

impl Cell {
    pub(super) fn new(text: Text) -> Self {
        Self { text, is_merged: false }
    }

    pub(super) fn is_number(&self) -> bool {
        let text = self.text.as_str();
        !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
    }
}

/// The lines of `text` without line breaks, each with its position.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_inclusive('\n').scan(0, |at, line| {
        let start = *at;
        *at += line.len();
        Some((start, line.trim_end_matches(['\n', '\r'])))
    })
}

/// Splits a sequence of cells into rows of `columns` cells.
///
/// A missing or extra cell would shift all following rows. If the first cell is a number, but some row would be
/// incomplete or not start with a number, each number starts a new row instead. In this way, only the invalid row has
/// the wrong number of cells.
pub(super) fn into_rows(cells: Vec<Cell>, columns: usize, page: Span) -> Vec<Row> {
    let columns = columns.max(1);
    let is_numbered = cells.first().is_some_and(Cell::is_number);
    let fits = cells.chunks(columns).all(|row| row.len() == columns && row[0].is_number());
    let mut groups: Vec<Vec<Cell>> = Vec::new();
    for cell in cells {
        let starts_group = is_numbered && !fits && cell.is_number();
        match groups.last_mut() {
            Some(group) if !starts_group => group.push(cell),
            _ => groups.push(vec![cell]),
        }
    }
    groups.into_iter().flat_map(|group| cut(group, columns, page)).collect()
}

/// Splits `cells` into rows. Cells that would fill less than two rows, but not exactly one row, form a single invalid
/// row.
fn cut(cells: Vec<Cell>, columns: usize, page: Span) -> Vec<Row> {
    let is_one_bad_row = !cells.len().is_multiple_of(columns) && cells.len() < 2 * columns;
    let size = if is_one_bad_row { cells.len() } else { columns };
    let mut rows = Vec::new();
    let mut rest = cells.into_iter().peekable();
    while rest.peek().is_some() {
        rows.push(Row::new(rest.by_ref().take(size).collect(), page));
    }
    rows
}
