//! Formatting of Markdown pages.

use std::collections::BTreeMap;
use std::ops::Range;

use pulldown_cmark::{Alignment, Event, Parser, Tag, TagEnd};
use uavspec_schema::table::markdown::OPTIONS;
use uavspec_schema::table::{Page, error_code, pipe};

use super::line::{line_of, line_starts, trimmed};
use crate::format::aligned::ALIGNED_WITHIN;

/// Formats a page. `written` contains the lines of `text`. `page` was parsed from the same text, possibly with
/// different line endings.
pub(super) fn lay_out(text: &str, written: &[&str], page: &Page) -> String {
    let structure = Structure::of(text);
    let starts = line_starts(text);
    let line_of = |at: usize| line_of(&starts, at);
    let mut lines: Vec<String> = written.iter().map(|line| trimmed(line).to_owned()).collect();
    for range in structure.verbatim.iter().filter(|range| !range.is_empty()) {
        for line in line_of(range.start)..=line_of(range.end - 1) {
            written[line].clone_into(&mut lines[line]);
        }
    }
    let mut tables = Vec::new();
    for (found, table) in structure.tables.iter().zip(&page.tables) {
        let Some(code) = error_code::code_column(table).filter(|_| found.is_outermost) else { continue };
        let first = line_of(found.range.start);
        let end = first + text[found.range.clone()].trim_end().split('\n').count();
        if let [header, _, rows @ ..] = &written[first..end] {
            let rows = [header].into_iter().chain(rows).map(|line| cells(line)).collect();
            tables.push(Codes { first, rows, alignments: &found.alignments, code });
        }
    }
    let widths = widths(&tables);
    for table in &tables {
        let columns = table.columns(widths.get(&table.rows[0]).map_or(&[], Vec::as_slice));
        for (line, laid_out) in (table.first..).zip(table.lines(&columns)) {
            lines[line] = laid_out;
        }
    }
    lines.join("\n")
}

/// The parts of a page's structure that affect formatting.
#[derive(Default)]
struct Structure {
    /// Ranges with significant white space: code, HTML, front matter, and spaces that break a line.
    verbatim: Vec<Range<usize>>,
    /// All tables, in order.
    tables: Vec<Found>,
}

struct Found {
    range: Range<usize>,
    alignments: Vec<Alignment>,
    /// True if the table is not nested in a quotation, list or footnote.
    is_outermost: bool,
}

impl Structure {
    fn of(text: &str) -> Self {
        let mut structure = Self::default();
        let mut depth = 0_usize;
        for (event, range) in Parser::new_ext(text, OPTIONS).into_offset_iter() {
            match event {
                Event::Start(Tag::BlockQuote(_) | Tag::List(_) | Tag::FootnoteDefinition(_)) => depth += 1,
                Event::End(TagEnd::BlockQuote(_) | TagEnd::List(_) | TagEnd::FootnoteDefinition) => {
                    depth = depth.saturating_sub(1);
                }
                Event::Start(Tag::CodeBlock(_) | Tag::HtmlBlock | Tag::MetadataBlock(_)) => {
                    structure.verbatim.push(range);
                }
                // On the last line of code or HTML, white space after the end of the code or HTML is insignificant.
                Event::Code(_) | Event::InlineHtml(_) => {
                    let end = text[range.clone()].rfind('\n').unwrap_or(0);
                    structure.verbatim.push(range.start..range.start + end);
                }
                // White space is significant only on the line before the break.
                Event::HardBreak => structure.verbatim.push(range.start..range.start + 1),
                Event::Start(Tag::Table(alignments)) => {
                    structure.tables.push(Found { range, alignments, is_outermost: depth == 0 });
                }
                _ => {}
            }
        }
        structure
    }
}

/// A table of error codes.
struct Codes<'s> {
    /// Index of the first line. The second line separates the header from the rows.
    first: usize,
    /// The cells of the header, followed by the cells of all rows.
    rows: Vec<Vec<&'s str>>,
    alignments: &'s [Alignment],
    /// Index of the column with the codes.
    code: usize,
}

struct Column {
    alignment: Alignment,
    width: usize,
}

impl Codes<'_> {
    /// The alignment and width of each column. Codes are aligned to the right; other columns keep their alignment.
    fn columns(&self, widths: &[usize]) -> Vec<Column> {
        let alignment = |index| if index == self.code { Alignment::Right } else { self.alignments[index] };
        let width = |index| widths.get(index).copied().unwrap_or(1);
        (0..self.alignments.len())
            .map(|index| Column { alignment: alignment(index), width: width(index) })
            .collect()
    }

    fn lines(&self, columns: &[Column]) -> Vec<String> {
        let mut lines: Vec<String> = self.rows.iter().map(|row| row_line(row, columns)).collect();
        lines.insert(1, divider(columns));
        lines
    }
}

/// Column widths by table header. All tables on a page that have the same header also have the same column widths. Each
/// column is as wide as its widest cell, except the last, which is as wide as its header.
fn widths<'s>(tables: &[Codes<'s>]) -> BTreeMap<Vec<&'s str>, Vec<usize>> {
    let mut widths = BTreeMap::new();
    for table in tables {
        let widths: &mut Vec<usize> =
            widths.entry(table.rows[0].clone()).or_insert_with(|| vec![1; table.alignments.len()]);
        for (index, row) in table.rows.iter().enumerate() {
            for (column, (width, cell)) in widths.iter_mut().zip(row).enumerate() {
                let is_aligned = index == 0 || column == table.code || column + 1 < table.alignments.len();
                let len = cell.chars().count();
                *width = if is_aligned && len <= ALIGNED_WITHIN { len.max(*width) } else { *width };
            }
        }
    }
    widths
}

fn cells(line: &str) -> Vec<&str> {
    let line = line.trim();
    pipe::cells(line).into_iter().map(|cell| line[cell].trim()).collect()
}

fn row_line(cells: &[&str], columns: &[Column]) -> String {
    let cell = |(index, cell): (usize, &&str)| match columns.get(index) {
        Some(Column { alignment: Alignment::Right, width }) => format!(" {cell:>width$} |"),
        Some(Column { width, .. }) if index + 1 < columns.len() => format!(" {cell:width$} |"),
        _ => format!(" {cell} |"),
    };
    String::from("|") + &cells.iter().enumerate().map(cell).collect::<String>()
}

fn divider(columns: &[Column]) -> String {
    let cell = |Column { alignment, width }: &Column| {
        let (left, right) = match alignment {
            Alignment::None => ("-", "-"),
            Alignment::Left => (":", "-"),
            Alignment::Center => (":", ":"),
            Alignment::Right => ("-", ":"),
        };
        format!("{left}{}{right}|", "-".repeat(*width))
    };
    String::from("|") + &columns.iter().map(cell).collect::<String>()
}
