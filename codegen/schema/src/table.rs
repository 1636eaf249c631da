//! Parses specification pages of all formats into headings and tables.
//!
//! The modules [`error_code`] and [`type_table`] recognize tables by their headers. Tables preserve rows with too few
//! or too many cells.

pub mod asciidoc;
pub mod error_code;
mod flattened;
pub mod markdown;
mod page;
pub mod pipe;
mod text;
pub mod type_table;

use self::page::lines;
pub use self::page::{Cell, Heading, Page, Row, Table};
pub use self::text::Text;
use crate::characters;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, SourceMap};

/// The format of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Markdown.
    Markdown,
    /// `AsciiDoc`.
    AsciiDoc,
    /// A text dump of an HTML page, in which each cell ends with a pipe and a line break.
    Flattened,
}

impl Form {
    /// Detects the format by extension if possible, otherwise by content. The content of Markdown files is always
    /// checked, because flattened pages are often saved as Markdown. If a flattened page were parsed as Markdown, its
    /// tables would have only one column.
    pub fn of(path: &str, text: &str) -> Self {
        let extension = path.rsplit_once('.').map_or("", |(_, extension)| extension);
        let is = |names: &[&str]| names.iter().any(|name| extension.eq_ignore_ascii_case(name));
        let is_markdown = is(&["md", "markdown"]);
        if is(&["adoc", "asciidoc"]) || (!is_markdown && asciidoc::is_likely(text)) {
            Self::AsciiDoc
        } else if flattened::is_likely(text) {
            Self::Flattened
        } else {
            Self::Markdown
        }
    }
}

/// Parses the source `id`. Returns a page with everything that could be read, and the diagnostics.
pub fn parse(sources: &SourceMap, id: SourceId) -> (Page, Vec<Diagnostic>) {
    let (text, span) = (sources.text(id), sources.span(id));
    let (page, mut diagnostics) = match Form::of(sources.path(id), text) {
        Form::Markdown => (markdown::parse(text, span), Vec::new()),
        Form::AsciiDoc => asciidoc::parse(text, span),
        Form::Flattened => (flattened::parse(text, span), Vec::new()),
    };
    for (at, line) in lines(text) {
        characters::check_invisible(line, span.part(at..at + line.len()), &mut diagnostics);
    }
    (page, diagnostics)
}

#[cfg(test)]
mod tests {
    use uavspec_test_definitions::extent;

    use super::*;

    /// One table in each of the formats that `Form::of` must distinguish.
    const FORMS: [(&str, &str); 5] = [
        (
            "page.md",
            "# Alpha\n\n| Code | Abbr | Description |\n|--:|---|---|\n| 64 | A\\|B | low *on* `fuel` |\n| 65 | | x |\n",
        ),
        (
            "page.md",
            "Alpha\n=====\n\nCode | Abbr | Description\n---|---|---\n64 | A\\|B | low on [fuel](x.md)\n65 | | x",
        ),
        (
            "page.adoc",
            "= Alpha\n\n[cols=\"1,2,9\"]\n|===\n|Code |Abbr |Description\n\n|64\n|A\\|B\n|low _on_\n`fuel`\n\n|65 | |x\n|===\n",
        ),
        (
            "page",
            "= Alpha\n|===\n|Code|Abbr|Description\n\n|64|A{vbar}B a|low on fuel\n// gone\n|65||x\n|===\n",
        ),
        (
            "page.txt",
            "Alpha\nCode | Abbr | Description |\n---|---|---|\n64 |\nA\\|B |\nlow on\nfuel |\n65 |\n|\nx |",
        ),
    ];

    fn parse_text(path: &str, text: &str) -> Page {
        let mut sources = SourceMap::default();
        let id = sources.add(path, text.into()).expect("short and UTF-8");
        parse(&sources, id).0
    }

    fn rows(table: &Table) -> Vec<Vec<&str>> {
        table.rows.iter().map(|row| row.cells.iter().map(|cell| cell.text.as_str()).collect()).collect()
    }

    #[test]
    fn all_forms_of_a_table_have_the_same_cells() {
        for (path, text) in FORMS {
            for text in [text.to_owned(), text.replace('\n', "\r\n"), text.replace('\n', "  \n")] {
                let page = parse_text(path, &text);
                let [table] = &page.tables[..] else { panic!("{path}: {text}") };
                assert_eq!(page.heading(table).expect("a heading").text.as_str(), "Alpha");
                let header: Vec<&str> = table.header.iter().map(|cell| cell.text.as_str()).collect();
                assert_eq!(header, ["Code", "Abbr", "Description"]);
                assert_eq!(rows(table), [["64", "A|B", "low on fuel"], ["65", "", "x"]], "{path}: {text}");
            }
        }
    }

    #[test]
    fn paragraphs_belong_to_the_heading_above_them() {
        let markdown = "before\n\n# A\n\none *two*\n  `three`\n\n- item\n\n  of a list\n\n> quoted\n\n## B\n|x|y|\n|-|-|\n|1|2|\n\nfour";
        let asciidoc = "before\n\n= A\n\none *two*\n// gone\n`three`\n\n* item\n\n== B\n|===\n|x |y\n\n|1 |2\n|===\nfour\n----\ncode\n----\n";
        let expected = [(None, "before"), (Some(0), "one two three"), (Some(1), "four")];
        for (path, text) in [("a.md", markdown), ("a.adoc", asciidoc)] {
            let page = parse_text(path, text);
            let found: Vec<_> = page
                .paragraphs
                .iter()
                .map(|paragraph| (paragraph.heading, paragraph.text.as_str()))
                .collect();
            assert_eq!(found, expected, "{path}");
            let after = page.paragraphs[2].text.span();
            assert!(page.tables[0].span < after && after.end as usize <= text.len(), "{path}");
        }
    }

    #[test]
    fn locates_a_part_of_a_cell_in_the_source() {
        for (path, text) in FORMS {
            let mut sources = SourceMap::default();
            sources.add("before", b"something else".to_vec()).expect("valid");
            let id = sources.add(path, text.into()).expect("valid");
            let (page, _) = parse(&sources, id);
            let row = &page.tables[0].rows[0];
            let fuel = row.cells[2].text.part("low on ".len().."low on fuel".len());
            assert_eq!(sources.slice(fuel), "fuel", "{path}");
            assert_eq!(sources.slice(row.cells[0].text.span()), "64");
            assert_eq!(sources.slice(row.cells[1].text.part(2..3)), "B");
        }
    }

    #[test]
    fn detects_the_flattened_form_by_content() {
        for path in ["page.md", "page", "page.text"] {
            assert_eq!(Form::of(path, FORMS[4].1), Form::Flattened);
        }
        assert_eq!(Form::of("page.adoc", FORMS[4].1), Form::AsciiDoc, "the extension has precedence");
        assert_eq!(Form::of("PAGE.MD", FORMS[2].1), Form::Markdown);
    }

    #[test]
    fn a_row_of_the_wrong_size_does_not_shift_the_next() {
        let adoc = "|===\n|C |A |D\n\n|1 |a |x\n|2 |b\n|3 |c |z\n|4 |d |y |more\n|5 |e |w\n|===";
        let text = "C | A | D |\n---|---|---|\n1 |\na |\nx |\n2 |\nb |\n3 |\nc |\nz |\n4 |\nd |\ny |\nmore |\n5 |\ne |\nw |";
        let markdown = "C|A|D\n-|-|-\n1|a|x\n2|b\n3|c|z\n4|d|y|more\n5|e|w";
        for (path, text) in [("a.adoc", adoc), ("a.txt", text), ("a.md", markdown)] {
            let page = parse_text(path, text);
            let sizes: Vec<usize> = page.tables[0].rows.iter().map(|row| row.cells.len()).collect();
            assert_eq!(sizes, [3, 2, 3, 4, 3], "{path}");
        }
    }

    /// In a thorough run, each of these pages takes about 20 ms. Quadratic algorithms would take minutes for a page.
    #[test]
    fn hostile_pages_are_read_in_linear_time() {
        let tables = ["", "|===\n|C |D\n\n|", "Code|Abbr|Description\n-|-|-\n", "a|b\n-|-\nx |\n"];
        let bodies = [
            "|", "|\n", "\\|", "x|y\n", "`a|", "64 |\n", "-|-\n", "|===\n", "a|2+|", "[a](", "<<", "link:",
            "link:a[", "*a _b ", "&",
        ];
        for path in ["a.md", "a.adoc", "a.txt"] {
            for (start, body) in tables.iter().flat_map(|start| bodies.map(|body| (start, body))) {
                let text = format!("# A\n\n{start}{}", body.repeat(extent(100_000, 8_000) / body.len()));
                parse_text(path, &text);
            }
        }
    }

    #[test]
    fn pages_without_tables_are_empty() {
        for text in
            ["", "\n\n", "# Only a heading", "== Only a heading", "|", "---|---", "|===", "a|b\n---|---"]
        {
            for path in ["a.md", "a.adoc", "a.txt"] {
                assert!(
                    parse_text(path, text).tables.iter().all(|table| table.rows.is_empty()),
                    "{path}: {text}"
                );
            }
        }
    }
}
