//! Reads GitHub-flavoured Markdown.

use std::ops::Range;

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use super::page::{Cell, Heading, Page, Paragraph, Row, Table};
use super::pipe;
use super::text::{TextBuilder, trim};
use crate::source::Span;

/// Parser options. Front matter and `{#anchors}`, which documentation generators require, are not part of the text.
pub const OPTIONS: Options = Options::ENABLE_TABLES
    .union(Options::ENABLE_HEADING_ATTRIBUTES)
    .union(Options::ENABLE_YAML_STYLE_METADATA_BLOCKS);

pub(super) fn parse(text: &str, span: Span) -> Page {
    let mut reader = Reader { text, page: Page::new(span), open: None, cells: Vec::new(), depth: 0 };
    for (event, range) in Parser::new_ext(text, OPTIONS).into_offset_iter() {
        reader.read(&event, range);
    }
    reader.page
}

struct Reader<'s> {
    text: &'s str,
    page: Page,
    /// The text of the current heading, cell or paragraph.
    open: Option<TextBuilder>,
    /// The cells of the current row.
    cells: Vec<Cell>,
    /// The nesting depth of lists, quotations and footnotes.
    depth: usize,
}

impl Reader<'_> {
    fn read(&mut self, event: &Event<'_>, range: Range<usize>) {
        match event {
            Event::Start(Tag::Heading { .. } | Tag::TableCell) => {
                self.open = Some(TextBuilder::new(self.page.span));
            }
            Event::Start(Tag::Paragraph) if self.depth == 0 => {
                self.open = Some(TextBuilder::new(self.page.span));
            }
            Event::End(TagEnd::Paragraph) => self.end_paragraph(range),
            Event::Start(Tag::BlockQuote(_) | Tag::List(_) | Tag::FootnoteDefinition(_)) => self.depth += 1,
            Event::End(TagEnd::BlockQuote(_) | TagEnd::List(_) | TagEnd::FootnoteDefinition) => {
                self.depth = self.depth.saturating_sub(1);
            }
            Event::End(TagEnd::Heading(level)) => self.end_heading(*level as usize, range),
            Event::Start(Tag::Table(_)) => self.start_table(range),
            Event::End(TagEnd::TableCell) => self.end_cell(range),
            Event::End(TagEnd::TableHead) => self.end_header(),
            Event::End(TagEnd::TableRow) => self.end_row(range),
            Event::Text(text) | Event::Code(text) => self.push(text, range),
            Event::InlineHtml(_) | Event::SoftBreak | Event::HardBreak => self.gap(event),
            _ => {}
        }
    }

    /// Adds `text`, which was read from `range` of the page.
    fn push(&mut self, text: &str, range: Range<usize>) {
        if let Some(open) = &mut self.open {
            open.push_read(text, self.text, range);
        }
    }

    /// Adds a gap for line breaks. Other HTML in a cell is ignored.
    fn gap(&mut self, event: &Event<'_>) {
        let is_gap = match event {
            Event::InlineHtml(html) => html.get(..3).is_some_and(|tag| tag.eq_ignore_ascii_case("<br")),
            _ => true,
        };
        if let Some(open) = self.open.as_mut().filter(|_| is_gap) {
            open.gap();
        }
    }

    fn end_heading(&mut self, level: usize, range: Range<usize>) {
        if let Some(open) = self.open.take() {
            let line = self.text[range.clone()].lines().next().unwrap_or("");
            let marks = line.len() - line.trim_start_matches('#').len();
            let text = open.finish(trim(self.text, range.start + marks..range.start + line.len()));
            self.page.headings.push(Heading { level, text });
        }
    }

    fn end_paragraph(&mut self, range: Range<usize>) {
        if let Some(open) = self.open.take() {
            let text = open.finish(trim(self.text, range));
            self.page.paragraphs.push(Paragraph { heading: self.page.headings.len().checked_sub(1), text });
        }
    }

    fn start_table(&mut self, range: Range<usize>) {
        let line = self.text[range.clone()].lines().next().map_or(0, str::len);
        self.page.tables.push(Table {
            heading: self.page.headings.len().checked_sub(1),
            title: None,
            header: Vec::new(),
            rows: Vec::new(),
            span: self.page.span.part(range.start..range.start + line),
        });
    }

    fn end_cell(&mut self, range: Range<usize>) {
        if let Some(open) = self.open.take() {
            self.cells.push(Cell::new(open.finish(trim(self.text, range))));
        }
    }

    fn end_header(&mut self) {
        let header = std::mem::take(&mut self.cells);
        if let Some(table) = self.page.tables.last_mut() {
            table.header = header;
        }
    }

    /// Restores the cells of a row as written. The Markdown parser pads short rows and truncates long rows, as GitHub
    /// does, but both are errors here.
    fn end_row(&mut self, range: Range<usize>) {
        let mut cells = std::mem::take(&mut self.cells);
        let range = trim(self.text, range);
        let written = pipe::cells(&self.text[range.clone()]);
        cells.truncate(written.len());
        for extra in written.into_iter().skip(cells.len()) {
            let place = range.start + extra.start..range.start + extra.end;
            if is_comment(&self.text[place.clone()]) {
                continue;
            }
            cells.push(pipe::plain_cell(self.text, place, self.page.span));
        }
        if let Some(table) = self.page.tables.last_mut() {
            table.rows.push(Row::new(cells, self.page.span));
        }
    }
}

/// True if the text after the last pipe of a row is a comment rather than a cell.
fn is_comment(text: &str) -> bool {
    let text = text.trim();
    text.starts_with("<!--") && text.ends_with("-->") && !text[4..].contains("<!--")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Page {
        parse(text, Span { start: 0, end: u32::try_from(text.len()).expect("short") })
    }

    fn first_row(text: &str) -> Vec<String> {
        let page = parse_text(text);
        page.tables[0].rows[0].cells.iter().map(|cell| cell.text.as_str().to_owned()).collect()
    }

    #[test]
    fn removes_markup_and_keeps_text() {
        let row = "**a**<br>b | `c\\|d` ~~x~~ | ![e](f) [g `h`](i) &amp; <b>j</b> \\*";
        assert_eq!(first_row(&format!("x|y|z\n-|-|-\n{row}")), ["a b", "c|d ~~x~~", "e g h & j *"]);
    }

    #[test]
    fn headings_have_levels_and_lose_their_attributes() {
        let page = parse_text("---\ntitle: t\n---\nA\n===\n## B *c* {#anchor}\n|x|\n|-|\n|y|\n### D");
        let headings: Vec<(usize, &str)> =
            page.headings.iter().map(|heading| (heading.level, heading.text.as_str())).collect();
        assert_eq!(headings, [(1, "A"), (2, "B c"), (3, "D")]);
        assert_eq!(page.tables[0].heading, Some(1));
    }

    #[test]
    fn tables_in_code_are_text() {
        assert!(parse_text("```\na|b\n-|-\n1|2\n```\n").tables.is_empty());
    }

    #[test]
    fn rows_keep_their_number_of_cells() {
        assert_eq!(first_row("a|b|c\n-|-|-\n1|2").len(), 2);
        assert_eq!(first_row("|a|b|\n|-|-|\n|1|2|3 \\| 4||"), ["1", "2", "3 | 4", ""]);
    }
}
