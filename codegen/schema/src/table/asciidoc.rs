//! `AsciiDoc`: headings and `|===` tables.

mod inline;

use std::ops::Range;

use self::inline::Line;
use super::page::{Cell, Heading, Page, Paragraph, Table, into_rows, lines};
use super::text::{Text, TextBuilder, trim};
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;

/// True if a text appears to be `AsciiDoc`.
pub(super) fn is_likely(text: &str) -> bool {
    lines(text).any(|(_, line)| is_table_fence(line.trim_end()))
}

pub(super) fn parse(text: &str, span: Span) -> (Page, Vec<Diagnostic>) {
    let lines: Vec<Line<'_>> = lines(text).map(|(at, line)| (at, line.trim_end())).collect();
    let mut parser = Parser { text, lines: &lines, page: Page::new(span), diagnostics: Vec::new() };
    parser.blocks();
    (parser.page, parser.diagnostics)
}

/// True if `line` starts or ends a table.
fn is_table_fence(line: &str) -> bool {
    line.strip_prefix("|===").is_some_and(|rest| rest.bytes().all(|byte| byte == b'='))
}

/// True if `line` starts or ends a block without markup: code, output or a comment.
fn is_verbatim_fence(line: &str) -> bool {
    let fence = |mark: char| line.len() >= 4 && line.chars().all(|c| c == mark);
    line == "```" || ['-', '.', '+', '/'].into_iter().any(fence)
}

/// True if `line` starts a list item.
fn is_list_item(line: &str) -> bool {
    let text = line.trim_start();
    let mark = text.len() - text.trim_start_matches(['*', '.', '-']).len();
    mark > 0 && text[mark..].starts_with(' ')
}

fn is_comment(line: &str) -> bool {
    line.starts_with("//") && !line.starts_with("///")
}

/// The level of a heading such as `== Text`, and the offset of its text.
fn heading_level(line: &str) -> Option<(usize, usize)> {
    let level = line.bytes().take_while(|byte| *byte == b'=').count();
    let rest = &line[level..];
    let text = rest.trim_start();
    ((1..=6).contains(&level) && rest.starts_with([' ', '\t']) && !text.is_empty())
        .then_some((level, line.len() - text.len()))
}

struct Parser<'s, 'l> {
    text: &'s str,
    lines: &'l [Line<'s>],
    page: Page,
    diagnostics: Vec<Diagnostic>,
}

impl Parser<'_, '_> {
    fn blocks(&mut self) {
        let mut prelude = Prelude::default();
        let mut index = 0;
        while let Some((at, line)) = self.lines.get(index).copied() {
            index += 1;
            if prelude.read(at, line) {
                continue;
            }
            let prelude = std::mem::take(&mut prelude);
            if is_verbatim_fence(line) {
                index = self.lines[index..]
                    .iter()
                    .position(|(_, end)| *end == line)
                    .map_or(index, |end| index + end + 1);
            } else if is_table_fence(line) {
                index = self.table(index, prelude);
            } else if let Some((level, start)) = heading_level(line) {
                let text = self.line_text(at + start..at + line.len());
                self.page.headings.push(Heading { level, text });
            } else if !is_list_item(line) {
                index = self.paragraph(index - 1);
            }
        }
    }

    /// Reads the paragraph that starts at line `first`, and returns the index of the line after it.
    fn paragraph(&mut self, first: usize) -> usize {
        let is_end = |line: &Line<'_>| {
            line.1.is_empty()
                || is_table_fence(line.1)
                || is_verbatim_fence(line.1)
                || heading_level(line.1).is_some()
        };
        let len = self.lines[first + 1..].iter().position(is_end);
        let end = len.map_or(self.lines.len(), |len| first + 1 + len);
        let lines = &self.lines[first..end];
        let mut builder = TextBuilder::new(self.page.span);
        let written: Vec<Line<'_>> = lines.iter().filter(|line| !is_comment(line.1)).copied().collect();
        inline::push(&written, &mut builder);
        let (last, line) = self.lines[end - 1];
        let text = builder.finish(self.lines[first].0..last + line.len());
        self.page.paragraphs.push(Paragraph { heading: self.page.headings.len().checked_sub(1), text });
        end
    }

    fn line_text(&self, range: Range<usize>) -> Text {
        let mut builder = TextBuilder::new(self.page.span);
        inline::push(&[(range.start, &self.text[range.clone()])], &mut builder);
        builder.finish(range)
    }

    /// Reads the table whose rows start at line `first`, and returns the index of the line after it.
    fn table(&mut self, first: usize, prelude: Prelude) -> usize {
        let (at, fence) = self.lines[first - 1];
        let span = self.page.span.part(at..at + fence.len());
        let is_end = |line: &Line<'_>| line.1 == fence || heading_level(line.1).is_some();
        let end = self.lines[first..].iter().position(is_end).map_or(self.lines.len(), |end| first + end);
        let is_closed = self.lines.get(end).is_some_and(|line| line.1 == fence);
        if !is_closed {
            self.diagnostics.push(Diagnostic::new(Problem::UnterminatedTable, span));
        }
        let mut body = Body::new(self.text, self.page.span);
        for line in self.lines[first..end].iter().filter(|line| !is_comment(line.1)) {
            body.line(*line);
        }
        let (mut header, columns) = body.finish(prelude.columns);
        let rows = header.split_off(columns.min(header.len()));
        let rows = into_rows(rows, header.len(), self.page.span);
        let heading = self.page.headings.len().checked_sub(1);
        let title = prelude.title.map(|title| self.line_text(title));
        self.page.tables.push(Table { heading, title, header, rows, span });
        if is_closed { end + 1 } else { end }
    }
}

/// The attributes and the title before a block.
#[derive(Default)]
struct Prelude {
    columns: Option<usize>,
    title: Option<Range<usize>>,
}

impl Prelude {
    /// Reads `line` if it is part of the prelude. Returns true for a prelude line, a comment or an empty line.
    fn read(&mut self, at: usize, line: &str) -> bool {
        if line.starts_with('[') && line.ends_with(']') {
            self.columns = columns(line).or(self.columns);
        } else if line.starts_with('.') && !line[1..].starts_with(['.', ' ']) {
            self.title = Some(at + 1..at + line.len());
        } else {
            return line.is_empty() || is_comment(line);
        }
        true
    }
}

/// The number of columns in `[cols="1,2*,3"]` or `[cols=4]`.
fn columns(attributes: &str) -> Option<usize> {
    let value = attributes.split_once("cols=")?.1;
    let value = match value.strip_prefix(['"', '\'']) {
        Some(quoted) => quoted.split(['"', '\'']).next()?,
        None => value.split([',', ']']).next()?,
    };
    if let Ok(count) = value.trim().parse::<usize>() {
        return Some(count.max(1));
    }
    let repeats = |column: &str| match column.trim().split_once('*') {
        Some((times, _)) => times.parse().unwrap_or(1),
        None => 1_usize,
    };
    Some(value.split([',', ';']).map(repeats).fold(0, usize::saturating_add).max(1))
}

/// Collects the cells of a table from its lines.
struct Body<'s> {
    text: &'s str,
    span: Span,
    cells: Vec<Cell>,
    /// The pieces of the current cell; `None` before the first pipe.
    open: Option<Vec<Line<'s>>>,
    is_merged: bool,
    /// The number of cells that start on the first line with cells.
    on_first_line: Option<usize>,
    /// The number of cells that start before the first empty line.
    before_blank_line: Option<usize>,
}

impl<'s> Body<'s> {
    fn new(text: &'s str, span: Span) -> Self {
        let (cells, open) = (Vec::new(), None);
        Self { text, span, cells, open, is_merged: false, on_first_line: None, before_blank_line: None }
    }

    /// The number of cells, including the current one.
    fn count(&self) -> usize {
        self.cells.len() + usize::from(self.open.is_some())
    }

    fn line(&mut self, (at, line): Line<'s>) {
        if line.is_empty() {
            self.before_blank_line = self.before_blank_line.or(Some(self.count())).filter(|cells| *cells > 0);
            return;
        }
        let mut start = 0;
        for (pipe, _) in line.match_indices('|') {
            let before = &line[start..pipe];
            if before.ends_with('\\') {
                continue;
            }
            let word = before.len() - last_word(before).len();
            let is_separate = start == 0 || word > 0;
            let specifier = specifier(&before[word..]).filter(|_| is_separate);
            self.extend(at + start, if specifier.is_some() { &before[..word] } else { before });
            self.close();
            self.is_merged = specifier == Some(Specifier::Merging);
            self.open = Some(Vec::new());
            start = pipe + 1;
        }
        self.extend(at + start, &line[start..]);
        self.on_first_line = self.on_first_line.or(Some(self.count())).filter(|cells| *cells > 0);
    }

    /// Adds text to the current cell. Text before the first pipe of a table is ignored.
    fn extend(&mut self, at: usize, text: &'s str) {
        if let Some(open) = &mut self.open {
            // A plus at the end of a line is a line break, which is treated as a space.
            open.push((at, text.strip_suffix(" +").unwrap_or(text)));
        }
    }

    fn close(&mut self) {
        let Some(stretches) = self.open.take() else { return };
        let first = stretches.first().map_or(0, |(at, _)| *at);
        let last = stretches.last().map_or(first, |(at, text)| at + text.len());
        let mut builder = TextBuilder::new(self.span);
        inline::push(&stretches, &mut builder);
        let text = builder.finish(trim(self.text, first..last));
        self.cells.push(Cell { text, is_merged: self.is_merged });
    }

    /// All cells, and the number of columns. If the attributes don't specify the number of columns, it is the number of
    /// cells on the first line. If the first line has only one cell, the header extends over several lines.
    fn finish(mut self, columns: Option<usize>) -> (Vec<Cell>, usize) {
        self.close();
        let on_first_line = self.on_first_line.filter(|cells| *cells > 1);
        let columns = columns.or(on_first_line).or(self.before_blank_line).unwrap_or(self.cells.len());
        (self.cells, columns)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Specifier {
    /// Alignment or style, which is ignored.
    Looks,
    /// Merged or repeated cells: `2+`, `.3+`, `4*`.
    Merging,
}

/// True if a specifier precedes any pipe of `line`. The result is also true if the last word of a cell only looks like
/// a specifier.
pub fn has_specifier(line: &str) -> bool {
    let parts = super::pipe::split(line);
    let before_pipes = &parts[..parts.len() - 1];
    before_pipes.iter().any(|part| specifier(last_word(&line[part.clone()])).is_some())
}

/// The text after the last white space.
fn last_word(text: &str) -> &str {
    text.rsplit(char::is_whitespace).next().unwrap_or(text)
}

/// Parses the format specifier before a pipe: `2.3+^.>s|`.
fn specifier(word: &str) -> Option<Specifier> {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let factor = digits(word);
    let factor = match word[factor..].strip_prefix('.') {
        Some(rows) => factor + 1 + digits(rows),
        None => factor,
    };
    let is_merging = factor > 0 && word[factor..].starts_with(['+', '*']);
    let rest = if is_merging { &word[factor + 1..] } else { word };
    let rest = rest.strip_prefix(['<', '^', '>']).unwrap_or(rest);
    let rest = rest.strip_prefix('.').and_then(|rest| rest.strip_prefix(['<', '^', '>'])).unwrap_or(rest);
    let rest = rest.strip_prefix(['a', 'd', 'e', 'h', 'l', 'm', 's', 'v']).unwrap_or(rest);
    let is_specifier = rest.is_empty() && !word.is_empty();
    is_specifier.then_some(if is_merging { Specifier::Merging } else { Specifier::Looks })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> (Page, Vec<Diagnostic>) {
        parse(text, Span { start: 0, end: u32::try_from(text.len()).expect("short") })
    }

    fn rows(table: &Table) -> Vec<Vec<&str>> {
        table.rows.iter().map(|row| row.cells.iter().map(|cell| cell.text.as_str()).collect()).collect()
    }

    #[test]
    fn cells_may_be_on_one_or_several_lines() {
        let head = "[%header,cols=\"1,2\"]\n.Title\n|===\n|C |D\n";
        for body in [
            "\n|1 |x y\n|2 |z\n",
            "|1\n|x\ny\n\n|2\n|z\n",
            "\n|1 |x\n\ny\n|2 |z",
            "|1|x y|2|z",
            "\n|1 a|x y\n// |9 |9\n^.>s|2|z +",
        ] {
            let (page, diagnostics) = parse_text(&format!("{head}{body}\n|===\n"));
            assert_eq!(rows(&page.tables[0]), [["1", "x y"], ["2", "z"]], "{body}");
            assert!(diagnostics.is_empty());
        }
    }

    #[test]
    fn column_count_comes_from_attributes_or_the_first_row() {
        for start in [
            "[cols=2]\n|===\n|C\n|D\n",
            "[cols=2*]\n|===\n|C\n|D\n",
            "[cols='1a,2']\n\n|===\n|C\n|D\n",
            "|===\n\n|C |D\n",
            "|===\n|C\n|D\n\n",
        ] {
            let (page, _) = parse_text(&format!("{start}|1\n|x\n|==="));
            assert_eq!(page.tables[0].header.len(), 2, "{start}");
        }
        let (page, _) =
            parse_text("[cols=\"99999999999999999999*,18446744073709551615*,2\"]\n|===\n|C |D\n|===");
        assert_eq!(page.tables[0].header.len(), 2);
        let (page, _) = parse_text("[cols=3]\n.T\nA paragraph.\n\n|===\n|C |D\n|1 |2\n|===");
        assert_eq!(page.tables[0].header.len(), 2, "the attributes belong to the paragraph");
        assert_eq!(page.tables[0].title, None);
    }

    #[test]
    fn specifiers() {
        for looks in ["a", "^", ".^", "^.>s", "<m"] {
            assert_eq!(specifier(looks), Some(Specifier::Looks), "{looks}");
        }
        for merging in ["2+", ".3+", "2.3+^", "4*", "2+a"] {
            assert_eq!(specifier(merging), Some(Specifier::Merging), "{merging}");
        }
        for text in ["", "2", "b", "word", "+", ".", "2+3", "aa"] {
            assert_eq!(specifier(text), None, "{text}");
        }
        let (page, _) = parse_text("|===\n|C |D\n\n|1a|x\n2+|y|\n|===");
        assert_eq!(rows(&page.tables[0])[0], ["1a", "x"], "white space precedes a specifier");
        assert!(page.tables[0].rows[1].cells[0].is_merged);
    }

    #[test]
    fn an_unclosed_table_ends_at_the_next_heading() {
        let (page, diagnostics) = parse_text("== A\n|===\n|C |D\n\n|1 |x\n\n== B\n|===\n|C |D\n\n|2 |y\n");
        assert_eq!(diagnostics.len(), 2);
        assert_eq!(page.tables.iter().flat_map(rows).collect::<Vec<_>>(), [["1", "x"], ["2", "y"]]);
        assert_eq!(page.heading(&page.tables[1]).expect("B").text.as_str(), "B");
    }

    #[test]
    fn skips_blocks_of_code_and_comments() {
        let (page, _) = parse_text("= A\n----\n== X\n|===\n|C\n|===\n----\n////\n== Y\n////\n....\n== Z\n");
        let headings: Vec<&str> = page.headings.iter().map(|heading| heading.text.as_str()).collect();
        assert_eq!(headings, ["A", "Z"], "an unclosed fence is ignored");
        assert!(page.tables.is_empty());
    }
}
