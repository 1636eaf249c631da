//! Reads tables of error codes: `Code | Abbr | Description`, in any order, with optional further columns.

mod block;

pub(crate) use self::block::{Block, parse_code, range_text};
use super::page::{Cell, Heading, Page, Row, Table};
use super::text::Text;
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;

/// All rows under one heading. An invalid heading doesn't invalidate the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCodeTable<'p> {
    /// The heading, or the header row of the table if there is no heading.
    pub span: Span,
    /// The parsed heading.
    pub block: Option<Block>,
    /// The valid rows.
    pub rows: Vec<ErrorCodeRow<'p>>,
    /// The codes of invalid rows. References to these codes are still valid.
    pub unread: Vec<u32>,
}

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCodeRow<'p> {
    /// The code.
    pub code: u32,
    /// The cell with the code.
    pub span: Span,
    /// The abbreviation; may be empty.
    pub abbreviation: &'p Text,
    /// The description.
    pub description: &'p Text,
    /// The version of the specification that introduced the code, if the table has a column for it.
    pub since: Option<&'p Text>,
}

/// Reads all error-code tables of a page. All tables under one heading are combined into one.
pub fn read(page: &Page) -> (Vec<ErrorCodeTable<'_>>, Vec<Diagnostic>) {
    let mut diagnostics = Vec::new();
    let mut tables: Vec<ErrorCodeTable<'_>> = Vec::new();
    let mut last_heading = None;
    for table in &page.tables {
        let heading = page.heading(table);
        let Some(columns) = Columns::of(table) else {
            diagnostics.extend(heading.and_then(|heading| unknown_columns(table, heading)));
            continue;
        };
        let title = table.title.as_ref().filter(|title| Block::parse(title.as_str()).is_ok());
        let heading = title.or(heading.map(|heading| &heading.text));
        if heading.is_none() || heading != last_heading {
            tables.push(start(table, heading, &mut diagnostics));
        }
        last_heading = heading;
        if let Some(open) = tables.last_mut() {
            for row in &table.rows {
                columns.read(row, open, &mut diagnostics);
            }
        }
    }
    (tables, diagnostics)
}

/// The column of the codes, if `table` contains error codes.
pub fn code_column(table: &Table) -> Option<usize> {
    Columns::of(table).map(|columns| columns.code)
}

fn start<'p>(table: &Table, heading: Option<&Text>, diagnostics: &mut Vec<Diagnostic>) -> ErrorCodeTable<'p> {
    let span = heading.map_or(table.span, Text::span);
    let block = match heading {
        None => Err(Problem::MissingHeading),
        Some(heading) => Block::parse(heading.as_str()),
    };
    let block = block.map_err(|problem| diagnostics.push(Diagnostic::new(problem, span))).ok();
    ErrorCodeTable { span, block, rows: Vec::new(), unread: Vec::new() }
}

/// Reports a table that resembles an error-code table, but lacks a column. Without this report, the codes in the table
/// would be silently ignored.
fn unknown_columns(table: &Table, heading: &Heading) -> Option<Diagnostic> {
    let has = |names: &[&str]| Columns::position(&table.header, names).is_some();
    let is_similar = (has(CODE) || has(ABBREVIATION)) && block::has_range(heading.text.as_str());
    let header: Vec<&str> = table.header.iter().map(|cell| cell.text.as_str()).collect();
    let span = table.header.first()?.text.span().to(table.header.last()?.text.span());
    is_similar.then(|| Diagnostic::new(Problem::UnknownColumns { header: header.join(" | ") }, span))
}

/// The names of the columns, for [`Columns::position`].
const CODE: &[&str] = &["code"];
const ABBREVIATION: &[&str] = &["abbr", "abbrev", "abbreviation"];
const DESCRIPTION: &[&str] = &["description"];
const SINCE: &[&str] = &["since"];

/// The positions of the columns.
struct Columns {
    count: usize,
    code: usize,
    abbreviation: usize,
    description: usize,
    since: Option<usize>,
}

impl Columns {
    fn of(table: &Table) -> Option<Self> {
        let position = |names| Self::position(&table.header, names);
        Some(Self {
            count: table.header.len(),
            code: position(CODE)?,
            abbreviation: position(ABBREVIATION)?,
            description: position(DESCRIPTION)?,
            since: position(SINCE),
        })
    }

    /// The first column with one of these names. Ignores case and a full stop at the end.
    fn position(header: &[Cell], names: &[&str]) -> Option<usize> {
        header.iter().position(|cell| {
            let name = cell.text.as_str().trim_end_matches('.');
            names.iter().any(|known| name.eq_ignore_ascii_case(known))
        })
    }

    fn read<'p>(&self, row: &'p Row, table: &mut ErrorCodeTable<'p>, diagnostics: &mut Vec<Diagnostic>) {
        let code = row.cells.get(self.code).map(|cell| (parse_code(cell.text.as_str()), &cell.text));
        let merged = row.cells.iter().find(|cell| cell.is_merged);
        let problem = match (merged, code) {
            (Some(cell), _) => Some((Problem::MergedCell, cell.text.span())),
            (None, _) if row.cells.len() != self.count => {
                Some((Problem::TableShape { expected: self.count, found: row.cells.len() }, row.span))
            }
            (None, Some((None, text))) => {
                Some((Problem::InvalidCode { text: text.as_str().to_owned() }, text.span()))
            }
            (None, _) => None,
        };
        if let Some((problem, span)) = problem {
            let mut diagnostic = Diagnostic::new(problem, span);
            if merged.is_none() && row.cells.len() > self.count {
                diagnostic = diagnostic.with_hint("`|`");
            }
            diagnostics.push(diagnostic);
            table.unread.extend(code.and_then(|(code, _)| code));
        } else if let Some((Some(code), text)) = code {
            table.rows.push(ErrorCodeRow {
                code,
                span: text.span(),
                abbreviation: &row.cells[self.abbreviation].text,
                description: &row.cells[self.description].text,
                since: self.since.map(|since| &row.cells[since].text),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceMap;

    fn codes(text: &str) -> Vec<&'static str> {
        let mut sources = SourceMap::default();
        let id = sources.add("page.md", text.into()).expect("valid");
        let (page, _) = crate::table::parse(&sources, id);
        read(&page).1.iter().map(|diagnostic| diagnostic.problem.code()).collect()
    }

    #[test]
    fn finds_columns_by_name() {
        let text = "# Warnings\n|Since|DESCRIPTION|Abbr.|code|x|\n|-|-|-|-|-|\n|2.1|low|FUEL|64||\n";
        let mut sources = SourceMap::default();
        let id = sources.add("page.md", text.into()).expect("valid");
        let (page, _) = crate::table::parse(&sources, id);
        let (tables, diagnostics) = read(&page);
        assert_eq!(diagnostics, []);
        let row = &tables[0].rows[0];
        assert_eq!((row.code, row.abbreviation.as_str(), row.description.as_str()), (64, "FUEL", "low"));
        assert_eq!(row.since.map(Text::as_str), Some("2.1"));
    }

    #[test]
    fn codes_are_plain_decimal_numbers() {
        for (text, code) in [("0", Some(0)), ("64", Some(64)), ("4294967295", Some(u32::MAX))] {
            assert_eq!(parse_code(text), code);
        }
        for text in ["", "+64", "-1", "064", "0x40", "6 4", "4294967296", "٣", "64."] {
            assert_eq!(parse_code(text), None, "{text}");
        }
    }

    #[test]
    fn other_tables_are_ignored() {
        assert_eq!(codes("# Warnings (codes 64-127)\n|Value|Description|\n|-|-|\n|1|x|\n"), [""; 0]);
        assert_eq!(codes("# Replies\n|Code|Meaning|\n|-|-|\n|1|x|\n"), [""; 0]);
        assert_eq!(codes("# Warnings (codes 64-127)\n|Code|Meaning|\n|-|-|\n|64|x|\n"), ["unknown-columns"]);
    }

    #[test]
    fn a_title_with_a_class_overrides_the_heading() {
        let table = |title: &str, code| {
            format!("\n{title}\n|===\n|Code |Abbr |Description\n\n|{code} |A{code} |x\n|===\n")
        };
        let text = format!(
            "== Codes\n{}{}",
            table(".Warnings", 64),
            table("[cols=3]\n.*Errors* (codes 128-191)\n[#errors]", 128)
        );
        let text = format!("{text}== Fatal errors\n{}{}", table(".Some of them", 192), table("", 193));
        let mut sources = SourceMap::default();
        let id = sources.add("page.adoc", text.into()).expect("valid");
        let (page, _) = crate::table::parse(&sources, id);
        let (tables, diagnostics) = read(&page);
        assert_eq!(diagnostics, []);
        let titles: Vec<_> =
            tables.iter().filter_map(|table| Some(table.block.as_ref()?.title.as_str())).collect();
        assert_eq!(titles, ["Warnings", "Errors", "Fatal errors"]);
        assert_eq!(tables[2].rows.len(), 2);
    }

    #[test]
    fn each_bad_row_and_heading_is_reported() {
        let head = "|Code|Abbr|Description|\n|-|-|-|\n";
        assert_eq!(codes(&format!("{head}|1|A|x|\n")), ["missing-heading"]);
        assert_eq!(
            codes(&format!("# Lemons\n{head}|x|A|x|\n|1|\n\nmore:\n\n{head}|2|B|y|z|\n")),
            ["unknown-class", "invalid-code", "table-shape", "table-shape"],
        );
    }
}
