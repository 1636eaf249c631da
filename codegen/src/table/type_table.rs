//! Tables of types and messages: what the header of a table and the heading above it define.
//!
//! | header | defines |
//! |---|---|
//! | `Field`, `Required`, `Type`, `Description` | a JSON object |
//! | `Index`, `Element`, `Required`, `Type`, `Description` | a JSON array with a meaning for each position |
//! | `Value`, `Description` | a set of strings or integers |
//!
//! A heading without such a table, whose first paragraph begins with a built-in type, names a type of its own:
//! `integer, [ms] Milliseconds since the epoch`. A heading with the subheadings `Request`, `Response` and
//! `Notification` is a message.

mod columns;
mod expression;
mod message;
mod note;

pub(crate) use self::expression::is_number;
pub(crate) use self::expression::{Expression, ExpressionKind};
pub use self::message::Direction;
pub(crate) use self::message::{MessageDefinition, PartDefinition};

use self::columns::{Columns, Header};
use self::note::read_note;
use super::{Heading, Page, Row, Table, Text};
use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::annotation::Note;
use crate::source::Span;

/// What a page defines beside error codes.
#[derive(Debug, Default)]
pub(crate) struct Definitions<'p> {
    /// Its types, in order.
    pub types: Vec<TypeDefinition<'p>>,
    /// Its messages, in order.
    pub messages: Vec<MessageDefinition<'p>>,
}

/// A type as it is written.
#[derive(Debug)]
pub(crate) struct TypeDefinition<'p> {
    /// Its name.
    pub name: &'p str,
    /// The heading.
    pub span: Span,
    /// The paragraphs between the heading and the table; those of a named type stand in its note.
    pub paragraphs: Vec<&'p Text>,
    /// The paragraphs below the table.
    pub remarks: Vec<&'p Text>,
    /// What it is.
    pub body: Body<'p>,
}

/// What a definition says beneath its heading.
#[derive(Debug)]
pub(crate) enum Body<'p> {
    /// A JSON object.
    Object(Vec<Member<'p>>),
    /// A JSON array with a meaning for each position.
    Tuple(Vec<Member<'p>>),
    /// A set of values.
    Set(Vec<Entry<'p>>),
    /// Another type, with a meaning and perhaps a range.
    Named {
        /// The other type.
        ty: Expression,
        /// What is said of it, a note for each paragraph.
        notes: Vec<Note<'p>>,
    },
}

/// A field of an object, or an element of a tuple.
#[derive(Debug)]
pub(crate) struct Member<'p> {
    /// Its name.
    pub name: &'p str,
    /// The cell of its name.
    pub span: Span,
    /// Whether it may not be left out.
    pub is_required: bool,
    /// Its type; none where that can't be read.
    pub ty: Option<Expression>,
    /// Its description.
    pub note: Note<'p>,
}

/// A value of a set.
#[derive(Debug)]
pub(crate) struct Entry<'p> {
    /// The value as it is written.
    pub value: &'p str,
    /// The cell of the value.
    pub span: Span,
    /// What it means.
    pub description: &'p str,
}

/// Reads the types and messages of a page.
pub(crate) fn read(page: &Page) -> (Definitions<'_>, Vec<Diagnostic>) {
    let mut reader = Reader { page, diagnostics: Vec::new(), is_defined: vec![false; page.headings.len()] };
    let messages = message::headings(page);
    let mut is_part = vec![false; page.headings.len()];
    let mut is_message = vec![false; page.headings.len()];
    for message in &messages {
        is_message[message.index()] = true;
        message.parts().for_each(|part| is_part[part] = true);
    }
    let mut definitions = Definitions::default();
    for table in &page.tables {
        match columns::header_of(table) {
            Some(Header::Near(columns)) => reader.report_near_miss(table, columns),
            Some(Header::Known(columns)) if !table.heading.is_some_and(|heading| is_part[heading]) => {
                definitions.types.extend(reader.type_of_table(table, &columns));
            }
            Some(Header::Known(_)) | None => {}
        }
    }
    for index in 0..page.headings.len() {
        if !reader.is_defined[index] && !is_message[index] && !is_part[index] {
            definitions.types.extend(reader.named_type(index));
        }
    }
    definitions.types.sort_by_key(|definition| definition.span);
    definitions.messages = messages.iter().filter_map(|message| reader.message(message)).collect();
    (definitions, reader.diagnostics)
}

struct Reader<'p> {
    page: &'p Page,
    diagnostics: Vec<Diagnostic>,
    /// By heading, whether a table under it defines something.
    is_defined: Vec<bool>,
}

impl<'p> Reader<'p> {
    fn report(&mut self, problem: Problem, span: Span) {
        self.diagnostics.push(Diagnostic::new(problem, span));
    }

    fn report_near_miss(&mut self, table: &Table, columns: &[&str]) {
        let header: Vec<&str> = table.header.iter().map(|cell| cell.text.as_str()).collect();
        let (Some(first), Some(last)) = (table.header.first(), table.header.last()) else { return };
        let problem = Problem::NearTypeTable { header: header.join(" | "), meant: columns.join(" | ") };
        self.report(problem, first.text.span().to(last.text.span()));
    }

    fn type_of_table(&mut self, table: &'p Table, columns: &Columns) -> Option<TypeDefinition<'p>> {
        let body = self.body(table, columns);
        let Some((index, heading)) =
            table.heading.and_then(|index| Some((index, self.page.headings.get(index)?)))
        else {
            self.diagnostics.push(
                Diagnostic::new(Problem::MissingHeading, table.span)
                    .with_hint("the heading names the type that the table defines"),
            );
            return None;
        };
        let name = heading.text.as_str();
        if !is_type_name(name) {
            self.report(Problem::TypeName { heading: name.to_owned() }, heading.text.span());
            return None;
        }
        if std::mem::replace(&mut self.is_defined[index], true) {
            let diagnostic = Diagnostic::new(Problem::DuplicateType { name: name.to_owned() }, table.span)
                .with_related(heading.text.span(), "the heading of both tables")
                .with_hint("give each table a heading of its own");
            self.diagnostics.push(diagnostic);
            return None;
        }
        let (paragraphs, remarks) = self.around(index, table);
        Some(TypeDefinition { name, span: heading.text.span(), paragraphs, remarks, body })
    }

    /// The paragraphs under a heading.
    fn paragraphs(&self, heading: usize) -> Vec<&'p Text> {
        let found = under(&self.page.paragraphs, heading, |paragraph| paragraph.heading);
        found.iter().map(|paragraph| &paragraph.text).collect()
    }

    /// The paragraphs under a heading, those above `table` and those below it.
    fn around(&self, heading: usize, table: &Table) -> (Vec<&'p Text>, Vec<&'p Text>) {
        self.paragraphs(heading).into_iter().partition(|text| text.span() < table.span)
    }

    fn body(&mut self, table: &'p Table, columns: &Columns) -> Body<'p> {
        match columns {
            Columns::Object { .. } => Body::Object(self.members(table, columns)),
            Columns::Tuple { .. } => Body::Tuple(self.members(table, columns)),
            Columns::Set => Body::Set(self.entries(table)),
        }
    }

    fn members(&mut self, table: &'p Table, columns: &Columns) -> Vec<Member<'p>> {
        let (Columns::Object { name, required, ty, description }
        | Columns::Tuple { name, required, ty, description, .. }) = *columns
        else {
            return Vec::new();
        };
        let mut members = Vec::with_capacity(table.rows.len());
        for (index, row) in table.rows.iter().enumerate() {
            if !self.is_whole(row, table) {
                continue;
            }
            if let Columns::Tuple { index: column, .. } = columns {
                self.check_index(&row.cells[*column].text, index);
            }
            let cell = &row.cells[name].text;
            if cell.is_empty() || cell.as_str().contains(char::is_whitespace) {
                let problem = Problem::InvalidName { name: cell.as_str().to_owned() };
                self.diagnostics.push(
                    Diagnostic::new(problem, cell.span()).with_hint("a name is one word, as JSON has it"),
                );
                continue;
            }
            members.push(Member {
                name: cell.as_str(),
                span: cell.span(),
                is_required: self.is_required(&row.cells[required].text),
                ty: expression::read(&row.cells[ty].text, &mut self.diagnostics),
                note: read_note(&row.cells[description].text, 0, &mut self.diagnostics),
            });
        }
        members
    }

    fn entries(&mut self, table: &'p Table) -> Vec<Entry<'p>> {
        let mut entries = Vec::with_capacity(table.rows.len());
        for row in &table.rows {
            if !self.is_whole(row, table) {
                continue;
            }
            let value = &row.cells[0].text;
            if value.is_empty() {
                let problem = Problem::InvalidName { name: String::new() };
                self.diagnostics.push(
                    Diagnostic::new(problem, value.span())
                        .with_hint("write the value; an empty string is `\"\"`"),
                );
                continue;
            }
            let description = row.cells[1].text.as_str();
            entries.push(Entry { value: value.as_str(), span: value.span(), description });
        }
        entries
    }

    /// Whether a row has a cell for each column.
    fn is_whole(&mut self, row: &Row, table: &Table) -> bool {
        if let Some(cell) = row.cells.iter().find(|cell| cell.is_merged) {
            self.report(Problem::MergedCell, cell.text.span());
            return false;
        }
        let (expected, found) = (table.header.len(), row.cells.len());
        if expected == found {
            return true;
        }
        let mut diagnostic = Diagnostic::new(Problem::TableShape { expected, found }, row.span);
        if found > expected {
            diagnostic = diagnostic.with_hint("a pipe that belongs to a text is written `\\|`");
        }
        self.diagnostics.push(diagnostic);
        false
    }

    fn check_index(&mut self, cell: &Text, expected: usize) {
        if cell.as_str() != expected.to_string() {
            let problem = Problem::TupleIndex { found: cell.as_str().to_owned(), expected };
            self.report(problem, cell.span());
        }
    }

    fn is_required(&mut self, cell: &Text) -> bool {
        let is = |word: &str| cell.as_str().eq_ignore_ascii_case(word);
        if !is("yes") && !is("no") {
            self.report(Problem::InvalidRequired { text: cell.as_str().to_owned() }, cell.span());
        }
        is("yes")
    }

    /// The type that a heading without a table names, if its first paragraph says one.
    fn named_type(&mut self, index: usize) -> Option<TypeDefinition<'p>> {
        let heading: &'p Heading = &self.page.headings[index];
        let paragraphs = self.paragraphs(index);
        let (first, rest) = paragraphs.split_first()?;
        let name = heading.text.as_str();
        let (ty, end) = expression::read_start(first).filter(|_| is_type_name(name))?;
        let mut notes = vec![read_note(first, end, &mut self.diagnostics)];
        notes.extend(rest.iter().map(|text| read_note(text, 0, &mut self.diagnostics)));
        let body = Body::Named { ty, notes };
        let span = heading.text.span();
        Some(TypeDefinition { name, span, paragraphs: Vec::new(), remarks: Vec::new(), body })
    }
}

/// Those of `items`, which stand in the order of the page, that have `heading` above them.
fn under<T>(items: &[T], heading: usize, heading_of: impl Fn(&T) -> Option<usize>) -> &[T] {
    let start = items.partition_point(|item| heading_of(item) < Some(heading));
    let len = items[start..].partition_point(|item| heading_of(item) == Some(heading));
    &items[start..start + len]
}

/// Whether a text can be the name of a type: one word in `PascalCase`.
fn is_type_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_uppercase())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceMap;

    fn page(text: &str) -> Page {
        let mut sources = SourceMap::default();
        let id = sources.add("page.md", text.into()).expect("valid");
        crate::table::parse(&sources, id).0
    }

    fn codes(text: &str) -> Vec<&'static str> {
        read(&page(text)).1.iter().map(|diagnostic| diagnostic.problem.code()).collect()
    }

    #[test]
    fn the_header_and_the_heading_say_what_is_defined() {
        let page = page(
            "# Gliders\n\n## Mark\n\nA turning point. Closed object.\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n\
             |name|yes|string|[@length 1, 8] Its name|\n\n## Wind\n\n|Description|Element|Index|Type|Required|\n|-|-|-|-|-|\n\
             |[m/s] Speed|speed|0|number|Yes|\n\n## Phase\n\nAn open set.\n\n|Value|Description|\n|-|-|\n|thermal|Circling|\n\n\
             ## Height\n\ninteger, [m] Above the sea.\n\n[@range 0, 9000]\n",
        );
        let (found, diagnostics) = read(&page);
        assert_eq!(diagnostics, []);
        let names: Vec<&str> = found.types.iter().map(|definition| definition.name).collect();
        assert_eq!(names, ["Mark", "Wind", "Phase", "Height"]);
        assert!(matches!(&found.types[0].body, Body::Object(fields) if fields[0].note.text == "Its name"));
        assert!(matches!(&found.types[1].body, Body::Tuple(elements) if elements[0].is_required));
        assert!(matches!(&found.types[2].body, Body::Set(entries) if entries[0].value == "thermal"));
        let Body::Named { ty, notes } = &found.types[3].body else { panic!("{:?}", found.types[3]) };
        assert_eq!(ty.kind, ExpressionKind::Integer);
        let annotations: Vec<usize> = notes.iter().map(|note| note.annotations.len()).collect();
        assert_eq!(annotations, [1, 1]);
        assert_eq!(notes[0].text, "Above the sea.");
    }

    #[test]
    fn what_stands_below_a_table_is_a_remark() {
        let page = page(
            "# Wind\n\nIt blows.\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n|speed|yes|number|How fast|\n\n\
             Disputed: whether it is a closed object.\n\n# WIND-INF\n\n## Notification\n\n\
             |Field|Required|Type|Description|\n|-|-|-|-|\n|wind|yes|Wind|The wind|\n\nNot stated: when.\n",
        );
        let found = read(&page).0;
        let texts = |texts: &[&Text]| texts.iter().map(|text| text.as_str().to_owned()).collect::<Vec<_>>();
        assert_eq!(texts(&found.types[0].paragraphs), ["It blows."]);
        assert_eq!(texts(&found.types[0].remarks), ["Disputed: whether it is a closed object."]);
        let part = &found.messages[0].parts[0];
        assert_eq!(
            (texts(&part.paragraphs), texts(&part.remarks)),
            (vec![], vec!["Not stated: when.".to_owned()])
        );
    }

    #[test]
    fn prose_stays_prose() {
        for text in [
            "# Gliders\n\ninteger overflow is no matter, here.\n",
            "# integer\n\nstring\n",
            "# Wind\n\nIt blows.\n\n|A|B|\n|-|-|\n|1|2|\n",
            "# Talk\n\n## Request\n\nAsk politely.\n",
        ] {
            let page = page(text);
            let (found, diagnostics) = read(&page);
            assert!(found.types.is_empty() && found.messages.is_empty() && diagnostics.is_empty(), "{text}");
        }
    }

    #[test]
    fn each_bad_row_and_heading_is_reported() {
        let fields = |rows: &str| format!("|Field|Required|Type|Description|\n|-|-|-|-|\n{rows}");
        assert_eq!(codes(&fields("|a|yes|string|x|\n")), ["missing-heading"]);
        assert_eq!(codes(&format!("# A wind\n{}", fields("|a|yes|string|x|\n"))), ["type-name"]);
        let rows = "|a|maybe|string|x|\n|b c|yes|string|x|\n|d|yes|\n|e|yes|list string|x|\n";
        assert_eq!(
            codes(&format!("# Wind\n{}", fields(rows))),
            ["invalid-required", "invalid-name", "table-shape", "invalid-type-expression"]
        );
        assert_eq!(codes("# Wind\n|Field|Type|Description|\n|-|-|-|\n|a|string|x|\n"), ["near-type-table"]);
    }
}
