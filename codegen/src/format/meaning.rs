//! What a source says, without the places at which it says it: equal before and after.

use pulldown_cmark::{Event, Parser, Tag, TagEnd, TextMergeStream};

use super::table::without_blank_end;
use crate::directive::Directive;
use crate::msg::Dialect;
use crate::msg::annotation::Note;
use crate::msg::ast::{Comment, Constant, Definition, Field, Item, Line, Part};
use crate::msg::statement::Statement;
use crate::schema::documentation::{self, Commentary, ItemDocs};
use crate::source::SourceMap;
use crate::table::{Cell, Form, Heading, Page, Row, Table, Text, markdown};

/// What a definition says: its declarations and comments, and what becomes documentation.
pub(super) fn of_definition(
    sources: &SourceMap,
    definition: &Definition<'_>,
    dialect: Dialect,
) -> Vec<String> {
    let mut said = Vec::new();
    for part in &definition.parts {
        said.push(of_commentary(part, dialect));
        said.extend(part.lines.iter().filter(|line| !line.is_blank()).map(|line| of_line(sources, line)));
    }
    said
}

fn of_commentary(part: &Part<'_>, dialect: Dialect) -> String {
    let Commentary { docs, groups, items, topics } = documentation::read(part, dialect);
    let items: Vec<_> = items.iter().map(|ItemDocs { description, group }| (description, group)).collect();
    let topics: Vec<&str> = topics.iter().map(|(topic, _)| *topic).collect();
    format!("{docs:?} {groups:?} {items:?} {topics:?}")
}

fn of_line(sources: &SourceMap, line: &Line<'_>) -> String {
    let item = match line.item.as_deref() {
        None => String::new(),
        Some(Item::Field(Field { ty, name, default })) => {
            format!("{} {} {default:?}", sources.slice(ty.span), name.text)
        }
        Some(Item::Constant(Constant { ty, name, value, .. })) => format!("{ty:?} {} = {value:?}", name.text),
    };
    format!("{item} {:?}", line.comment.as_deref().map(of_comment))
}

fn of_comment(comment: &Comment<'_>) -> String {
    let text = match &comment.note {
        Some(note) => of_note(note),
        // Blanks count in documentation alone, and of that the commentary has all.
        None => comment.text.split_whitespace().collect::<Vec<_>>().join(" "),
    };
    let directive = comment.directive.map(|Directive { rule, reason, .. }| (rule, reason));
    format!("{text} {directive:?}")
}

/// What a comment says of its declaration. The order of annotations says nothing where they differ in kind.
pub(super) fn of_note(note: &Note<'_>) -> String {
    let mut statements: Vec<&Statement<'_>> =
        note.annotations.iter().map(|annotation| &annotation.statement).collect();
    statements.sort_by_key(|statement| statement.rank());
    let parameters: Vec<String> = note.parameters.iter().map(of_note).collect();
    format!("{statements:?} {:?} {parameters:?}", note.text)
}

/// What a page says: its headings and tables, and of Markdown all that it shows.
pub(super) fn of_page(path: &str, text: &str, page: &Page) -> Vec<String> {
    let form = Form::of(path, text);
    let mut said = vec![format!("{form:?}")];
    said.extend(page.headings.iter().map(|Heading { level, text }| format!("{level} {:?}", text.as_str())));
    for Table { heading, title, header, rows, .. } in &page.tables {
        said.push(format!("{heading:?} {:?} {}", title.as_ref().map(Text::as_str), of_cells(header)));
        said.extend(rows.iter().map(|Row { cells, .. }| of_cells(cells)));
    }
    if form == Form::Markdown {
        said.extend(shown(text));
    }
    said
}

fn of_cells(cells: &[Cell]) -> String {
    let cells: Vec<_> = cells.iter().map(|cell| (cell.text.as_str(), cell.is_merged)).collect();
    format!("{cells:?}")
}

/// What a reader of a Markdown page sees, apart from the alignment of columns.
fn shown(text: &str) -> Vec<String> {
    // An end of line has no other meaning for being written in two characters, nor has the last for being there.
    let text = without_blank_end(text).replace("\r\n", "\n") + "\n";
    // White space at the ends of a heading or cell isn't shown. What they say was compared already.
    let mut is_trimmed = false;
    let mut shown = Vec::new();
    for event in TextMergeStream::new(Parser::new_ext(&text, markdown::OPTIONS)) {
        match &event {
            Event::Start(Tag::TableCell | Tag::Heading { .. }) => is_trimmed = true,
            Event::End(TagEnd::TableCell | TagEnd::Heading(_)) => is_trimmed = false,
            _ => {}
        }
        shown.push(match event {
            Event::Start(Tag::Table(_)) => "table".to_owned(),
            Event::Text(text) if is_trimmed => format!("{:?}", text.trim()),
            event => format!("{event:?}"),
        });
    }
    shown
}
