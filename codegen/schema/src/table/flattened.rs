//! Reads tables of an HTML page that was saved as text. The heading, the header and its divider are one line each. Each
//! cell ends with a pipe and a line break.
//!
//! ```text
//! Warnings (codes 64-127)
//! Code | Abbr | Description |
//! ---|---|---|
//! 64 |
//! FUEL |
//! Fuel is low. |
//! ```

use std::ops::Range;

use super::page::{Cell, Heading, Page, Table, into_rows, lines};
use super::pipe;
use super::text::{TextBuilder, trim};
use crate::source::Span;

/// A line and its position.
type Line<'s> = (usize, &'s str);

/// True if the first line of any table body contains a single cell.
pub(super) fn is_likely(text: &str) -> bool {
    let mut is_body = false;
    for (_, line) in lines(text) {
        let line = line.trim();
        if is_body && !line.is_empty() {
            if line.ends_with('|') && pipe::split(line).len() == 2 {
                return true;
            }
            is_body = false;
        }
        // Skip tables with one column, because such tables look the same in Markdown.
        is_body |= pipe::is_divider(line) && pipe::cells(line).len() > 1;
    }
    false
}

pub(super) fn parse(text: &str, span: Span) -> Page {
    let lines: Vec<Line<'_>> = lines(text).collect();
    let mut page = Page::new(span);
    let heads = heads(&lines);
    for (index, head) in heads.iter().enumerate() {
        let end = heads.get(index + 1).map_or(lines.len(), |next| next.start);
        if let Some(line) = head.heading {
            page.headings.push(heading(lines[line], span));
        }
        let (at, line) = lines[head.header];
        let header: Vec<Cell> = pipe::cells(line)
            .into_iter()
            .map(|cell| pipe::plain_cell(text, at + cell.start..at + cell.end, span))
            .collect();
        let cells =
            Body { text, span, columns: header.len(), cells: Vec::new(), open: Vec::new(), paragraph: None }
                .read(&lines[head.header + 2..end]);
        page.tables.push(Table {
            heading: head.heading.and_then(|_| page.headings.len().checked_sub(1)),
            title: None,
            rows: into_rows(cells, header.len(), span),
            header,
            span: span.part(trim(text, at..at + line.len())),
        });
    }
    page
}

/// The line numbers of a table's heading and header row.
struct Head {
    heading: Option<usize>,
    header: usize,
    /// The first line, which is the heading or the header.
    start: usize,
}

fn heads(lines: &[Line<'_>]) -> Vec<Head> {
    let mut heads: Vec<Head> = Vec::new();
    for header in 0..lines.len().saturating_sub(1) {
        if !lines[header].1.contains('|') || !pipe::is_divider(lines[header + 1].1) {
            continue;
        }
        let first = heads.last().map_or(0, |head| head.header + 2);
        let heading = (first..header)
            .rev()
            .find(|line| !lines[*line].1.trim().is_empty())
            .filter(|line| pipe::split(lines[*line].1).len() == 1);
        if first <= header {
            heads.push(Head { heading, header, start: heading.unwrap_or(header) });
        }
    }
    heads
}

fn heading((at, line): Line<'_>, page: Span) -> Heading {
    // Skip the heading marks, which some dumps keep.
    let marks = line.len() - line.trim_start_matches(['#', ' ']).len();
    let mut builder = TextBuilder::new(page);
    builder.push(&line[marks..], at + marks);
    Heading { level: 1, text: builder.finish(at + marks..at + line.trim_end().len().max(marks)) }
}

/// Collects the cells of a table from the lines below its header.
struct Body<'s> {
    text: &'s str,
    span: Span,
    columns: usize,
    cells: Vec<Cell>,
    /// The line ranges of the current cell.
    open: Vec<Range<usize>>,
    /// The number of lines in the current cell before its first empty line.
    paragraph: Option<usize>,
}

impl<'s> Body<'s> {
    fn read(mut self, lines: &[Line<'s>]) -> Vec<Cell> {
        for (at, line) in lines {
            if line.trim().is_empty() {
                self.paragraph = self.paragraph.or(Some(self.open.len())).filter(|lines| *lines > 0);
            } else {
                self.line(*at, line);
            }
        }
        // The pipe of the last cell may be missing. Text after a complete row is prose.
        if !self.cells.len().is_multiple_of(self.columns) && !self.open.is_empty() {
            self.open.truncate(self.paragraph.unwrap_or(usize::MAX));
            self.close();
        }
        self.cells
    }

    fn line(&mut self, at: usize, line: &str) {
        let mut parts = pipe::split(line);
        // A row on one line may start with a pipe. A line with only one pipe is a cell.
        if parts.len() > 2 && self.open.is_empty() && line.trim_start().starts_with('|') {
            parts.remove(0);
        }
        let rest = parts.pop();
        for part in parts {
            self.open.push(at + part.start..at + part.end);
            self.close();
        }
        self.open.extend(
            rest.filter(|rest| !line[rest.clone()].trim().is_empty())
                .map(|rest| at + rest.start..at + rest.end),
        );
    }

    fn close(&mut self) {
        let mut builder = TextBuilder::new(self.span);
        let first = self.open.first().map_or(0, |line| line.start);
        let last = self.open.last().map_or(first, |line| line.end);
        for line in self.open.drain(..) {
            builder.gap();
            builder.push_unescaped(&self.text[line.clone()], line.start);
        }
        self.paragraph = None;
        self.cells.push(Cell::new(builder.finish(trim(self.text, first..last))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Page {
        parse(text, Span { start: 0, end: u32::try_from(text.len()).expect("short") })
    }

    fn cells(table: &Table) -> Vec<&str> {
        table.rows.iter().flat_map(|row| row.cells.iter().map(|cell| cell.text.as_str())).collect()
    }

    #[test]
    fn tables_follow_each_other_without_a_gap() {
        let page =
            parse_text("Intro\n\nA\nC | D |\n---|---|\n1 |\nx |\n2 |\ny\nB\nC | D |\n---|---|\n3 |\nz");
        let headings: Vec<&str> = page.headings.iter().map(|heading| heading.text.as_str()).collect();
        assert_eq!(headings, ["A", "B"]);
        assert_eq!(cells(&page.tables[0]), ["1", "x", "2", "y"], "a missing pipe ends at the next heading");
        assert_eq!(cells(&page.tables[1]), ["3", "z"], "and at the end of the file");
    }

    #[test]
    fn prose_between_tables_is_ignored() {
        let page = parse_text(
            "A\nC | D |\n---|---|\n1 |\nx |\n\nSome words\nover lines.\n\n## B\n\nC | D |\n-|-|\n3 |\nz\n\nEnd.",
        );
        assert_eq!(page.headings[1].text.as_str(), "B");
        assert_eq!(cells(&page.tables[0]), ["1", "x"]);
        assert_eq!(cells(&page.tables[1]), ["3", "z"]);
    }

    #[test]
    fn cells_wrap_over_lines_and_may_be_empty() {
        let page = parse_text("A\nC | D | E |\n---|---|---|\n1 |\n|\nlong\n text \n|\n| 2 | b |\nc\\|d |\n");
        assert_eq!(cells(&page.tables[0]), ["1", "", "long text", "2", "b", "c|d"]);
    }

    #[test]
    fn a_table_without_a_heading_has_none() {
        let page = parse_text("A\nC | D |\n---|---|\n1 |\nx |\nC | D |\n---|---|\n2 |\ny |\n");
        assert_eq!(page.tables[1].heading, None);
        assert_eq!(cells(&page.tables[0]), ["1", "x"]);
        assert!(parse_text("---|---|\n---|---|\n---|---|\n---|---|").tables.len() <= 2);
    }
}
