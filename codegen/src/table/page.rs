//! Pages, whatever their form.

use super::text::Text;
use crate::source::Span;

/// A page, as far as it defines anything.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The whole page.
    pub span: Span,
    /// Its headings in order. Their levels say which of them are above which.
    pub headings: Vec<Heading>,
    /// Its tables in order.
    pub tables: Vec<Table>,
    /// Its paragraphs in order, but those of lists and quotations. A flattened page has none: which lines belong
    /// together is lost there.
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
    /// 1 for the title of a page, 2 for its sections, and so on. All are 1 in the flattened form.
    pub level: usize,
    /// What it says.
    pub text: Text,
}

/// A paragraph.
#[derive(Clone, Debug, PartialEq)]
pub struct Paragraph {
    /// Which of the page's headings is the nearest above it.
    pub heading: Option<usize>,
    /// What it says.
    pub text: Text,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Which of the page's headings is the nearest above it.
    pub heading: Option<usize>,
    /// A title of its own, which only `AsciiDoc` has.
    pub title: Option<Text>,
    /// The cells of its first row.
    pub header: Vec<Cell>,
    /// All further rows.
    pub rows: Vec<Row>,
    /// Where it starts: its header, or the line that opens it.
    pub span: Span,
}

/// A row as it was written: it may have another number of cells than the header.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its cells.
    pub cells: Vec<Cell>,
    /// From its first cell to its last.
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
    /// What it says, without markup.
    pub text: Text,
    /// Whether it is written once for several columns, rows or cells (`AsciiDoc` only).
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

/// The lines of `text` without their ends, each with its position.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split_inclusive('\n').scan(0, |at, line| {
        let start = *at;
        *at += line.len();
        Some((start, line.trim_end_matches(['\n', '\r'])))
    })
}

/// Cuts a flow of cells, in which only the count says where a row ends, into rows of `columns`.
///
/// One cell too few or too many would shift all rows after it. Where each row should start with a
/// number and some don't, the numbers say where rows start, so that only the bad row has the wrong
/// count.
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

/// Cuts `cells` into rows. What is less than two rows but not one stays together: the cell that is
/// missing or too much is somewhere in it.
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
