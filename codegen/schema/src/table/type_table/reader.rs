//! Reads the types of a page.

use super::columns::Columns;
use super::expression::{self, Expression, is_type_name};
use super::note::read_note;
use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::annotation::Note;
use crate::source::Span;
use crate::table::page::{Heading, Page, Row, Table};
use crate::table::text::Text;

/// A type as written.
#[derive(Debug)]
pub struct TypeDefinition<'p> {
    /// The name.
    pub name: &'p str,
    /// The heading.
    pub span: Span,
    /// The paragraphs between the heading and the table; empty for a named type, whose paragraphs are notes.
    pub paragraphs: Vec<&'p Text>,
    /// The paragraphs below the table.
    pub remarks: Vec<&'p Text>,
    /// The definition.
    pub body: Body<'p>,
}

/// The definition of a type.
#[derive(Debug)]
pub enum Body<'p> {
    /// A JSON object.
    Object(Vec<Member<'p>>),
    /// A JSON array with a meaning for each position.
    Tuple(Vec<Member<'p>>),
    /// A set of values.
    Set(Vec<Entry<'p>>),
    /// An alias of another type, with a description and optional restrictions.
    Named {
        /// The aliased type.
        ty: Expression,
        /// The notes, one for each paragraph.
        notes: Vec<Note<'p>>,
    },
}

/// A field of an object, or an element of a tuple.
#[derive(Debug)]
pub struct Member<'p> {
    /// The name.
    pub name: &'p str,
    /// The cell with the name.
    pub span: Span,
    /// True if the field or element is required.
    pub is_required: bool,
    /// The type, or `None` if it is invalid.
    pub ty: Option<Expression>,
    /// The description.
    pub note: Note<'p>,
}

/// A value of a set.
#[derive(Debug)]
pub struct Entry<'p> {
    /// The value as written.
    pub value: &'p str,
    /// The cell of the value.
    pub span: Span,
    /// The description.
    pub description: &'p str,
}

pub(super) struct Reader<'p> {
    pub(super) page: &'p Page,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// True for each heading with a table that defines a type.
    pub(super) is_defined: Vec<bool>,
}

impl<'p> Reader<'p> {
    pub(super) fn report(&mut self, problem: Problem, span: Span) {
        self.diagnostics.push(Diagnostic::new(problem, span));
    }

    pub(super) fn report_near_miss(&mut self, table: &Table, columns: &[&str]) {
        let header: Vec<&str> = table.header.iter().map(|cell| cell.text.as_str()).collect();
        let (Some(first), Some(last)) = (table.header.first(), table.header.last()) else { return };
        let problem = Problem::NearTypeTable { header: header.join(" | "), expected: columns.join(" | ") };
        self.report(problem, first.text.span().to(last.text.span()));
    }

    pub(super) fn type_of_table(
        &mut self,
        table: &'p Table,
        columns: &Columns,
    ) -> Option<TypeDefinition<'p>> {
        let body = self.body(table, columns);
        let Some((index, heading)) =
            table.heading.and_then(|index| Some((index, self.page.headings.get(index)?)))
        else {
            self.diagnostics.push(
                Diagnostic::new(Problem::MissingHeading, table.span)
                    .with_hint("add a heading with the name of the type"),
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
                .with_related(heading.text.span(), "heading of both tables")
                .with_hint("give each table a separate heading");
            self.diagnostics.push(diagnostic);
            return None;
        }
        let (paragraphs, remarks) = self.around(index, table);
        Some(TypeDefinition { name, span: heading.text.span(), paragraphs, remarks, body })
    }

    /// The paragraphs under a heading.
    pub(super) fn paragraphs(&self, heading: usize) -> Vec<&'p Text> {
        let found = under(&self.page.paragraphs, heading, |paragraph| paragraph.heading);
        found.iter().map(|paragraph| &paragraph.text).collect()
    }

    /// The paragraphs under a heading, split into paragraphs above and below `table`.
    pub(super) fn around(&self, heading: usize, table: &Table) -> (Vec<&'p Text>, Vec<&'p Text>) {
        self.paragraphs(heading).into_iter().partition(|text| text.span() < table.span)
    }

    pub(super) fn body(&mut self, table: &'p Table, columns: &Columns) -> Body<'p> {
        match columns {
            Columns::Object { .. } => Body::Object(self.members(table, columns)),
            Columns::Tuple { .. } => Body::Tuple(self.members(table, columns)),
            Columns::Set => Body::Set(self.entries(table)),
        }
    }

    pub(super) fn members(&mut self, table: &'p Table, columns: &Columns) -> Vec<Member<'p>> {
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
                    Diagnostic::new(problem, cell.span()).with_hint("write the name as one word, as in JSON"),
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

    pub(super) fn entries(&mut self, table: &'p Table) -> Vec<Entry<'p>> {
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

    /// True if a row has one cell for each column; otherwise, an error is reported.
    pub(super) fn is_whole(&mut self, row: &Row, table: &Table) -> bool {
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
            diagnostic = diagnostic.with_hint("`|`");
        }
        self.diagnostics.push(diagnostic);
        false
    }

    pub(super) fn check_index(&mut self, cell: &Text, expected: usize) {
        if cell.as_str() != expected.to_string() {
            let problem = Problem::TupleIndex { found: cell.as_str().to_owned(), expected };
            self.report(problem, cell.span());
        }
    }

    pub(super) fn is_required(&mut self, cell: &Text) -> bool {
        let is = |word: &str| cell.as_str().eq_ignore_ascii_case(word);
        if !is("yes") && !is("no") {
            self.report(Problem::InvalidRequired { text: cell.as_str().to_owned() }, cell.span());
        }
        is("yes")
    }

    /// The type that a heading without a table defines, if its first paragraph starts with a type.
    pub(super) fn named_type(&mut self, index: usize) -> Option<TypeDefinition<'p>> {
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

/// The `items` directly under `heading`. The items must be in page order.
pub(super) fn under<T>(items: &[T], heading: usize, heading_of: impl Fn(&T) -> Option<usize>) -> &[T] {
    let start = items.partition_point(|item| heading_of(item) < Some(heading));
    let len = items[start..].partition_point(|item| heading_of(item) == Some(heading));
    &items[start..start + len]
}
