//! Markdown.

use std::collections::BTreeMap;
use std::ops::Range;

use pulldown_cmark::{Alignment, Event, Parser, Tag, TagEnd};

use super::trimmed;
use crate::format::ALIGNED_WITHIN;
use crate::table::markdown::OPTIONS;
use crate::table::{Page, error_code, pipe};

/// The page laid out. `page` was read from the same text, but for the ends of lines.
pub(super) fn lay_out(text: &str, page: &Page) -> String {
    let structure = Structure::of(text);
    let starts = line_starts(text);
    let line_of = |at: usize| starts.partition_point(|start| *start <= at) - 1;
    let mut lines: Vec<String> = text.split('\n').map(|line| trimmed(line).to_owned()).collect();
    let written: Vec<&str> = text.split('\n').collect();
    for range in structure.verbatim.iter().filter(|range| !range.is_empty()) {
        for line in line_of(range.start)..=line_of(range.end - 1) {
            written[line].clone_into(&mut lines[line]);
        }
    }
    for (found, table) in structure.tables.iter().zip(&page.tables) {
        let Some(code) = error_code::code_column(table).filter(|_| found.is_outermost) else { continue };
        let first = line_of(found.range.start);
        let end = first + text[found.range.clone()].trim_end().split('\n').count();
        if let Some(laid_out) = table_lines(&written[first..end], &found.alignments, code) {
            lines.splice(first..end, laid_out);
        }
    }
    lines.join("\n")
}

/// Where each line starts.
fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect()
}

/// What of a page has to be known before lines are touched.
#[derive(Default)]
struct Structure {
    /// Text whose white space counts: code, HTML, front matter, and blanks that break a line.
    verbatim: Vec<Range<usize>>,
    /// All tables in order.
    tables: Vec<Found>,
}

struct Found {
    range: Range<usize>,
    alignments: Vec<Alignment>,
    /// Whether its lines hold nothing else, such as the `>` of a quotation.
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
                // What follows on the last line isn't part of it any more.
                Event::Code(_) | Event::InlineHtml(_) => {
                    let end = text[range.clone()].rfind('\n').unwrap_or(0);
                    structure.verbatim.push(range.start..range.start + end);
                }
                // The line that is broken, not the next.
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

/// The lines of a table laid out. Its first line is the header, its second divides that from the rows.
fn table_lines(lines: &[&str], alignments: &[Alignment], code: usize) -> Option<Vec<String>> {
    let (header, rows) = (lines.first()?, lines.get(2..)?);
    let rows: Vec<Vec<&str>> = [header].into_iter().chain(rows).map(|line| cells(line)).collect();
    let columns = columns(&rows, alignments, code);
    let mut laid_out: Vec<String> = rows.iter().map(|row| row_line(row, &columns)).collect();
    laid_out.insert(1, divider(&columns));
    Some(laid_out)
}

fn cells(line: &str) -> Vec<&str> {
    let line = line.trim();
    pipe::cells(line).into_iter().map(|cell| line[cell].trim()).collect()
}

struct Column {
    alignment: Alignment,
    width: usize,
}

/// Codes stand to the right. All columns are as wide as their widest cell, but for the last.
fn columns(rows: &[Vec<&str>], alignments: &[Alignment], code: usize) -> BTreeMap<usize, Column> {
    let width_of = |row: &Vec<&str>, column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
    let column = |(index, alignment): (usize, &Alignment)| {
        let aligned = if index + 1 == alignments.len() && index != code { &rows[..1] } else { rows };
        let widths = aligned.iter().map(|row| width_of(row, index)).filter(|width| *width <= ALIGNED_WITHIN);
        let alignment = if index == code { Alignment::Right } else { *alignment };
        (index, Column { alignment, width: widths.max().unwrap_or(0).max(1) })
    };
    alignments.iter().enumerate().map(column).collect()
}

fn row_line(cells: &[&str], columns: &BTreeMap<usize, Column>) -> String {
    let cell = |(index, cell): (usize, &&str)| match columns.get(&index) {
        Some(Column { alignment: Alignment::Right, width }) => format!(" {cell:>width$} |"),
        Some(Column { width, .. }) if index + 1 < columns.len() => format!(" {cell:width$} |"),
        _ => format!(" {cell} |"),
    };
    String::from("|") + &cells.iter().enumerate().map(cell).collect::<String>()
}

fn divider(columns: &BTreeMap<usize, Column>) -> String {
    let cell = |Column { alignment, width }: &Column| {
        let (left, right) = match alignment {
            Alignment::None => ("-", "-"),
            Alignment::Left => (":", "-"),
            Alignment::Center => (":", ":"),
            Alignment::Right => ("-", ":"),
        };
        format!("{left}{}{right}|", "-".repeat(*width))
    };
    String::from("|") + &columns.values().map(cell).collect::<String>()
}
