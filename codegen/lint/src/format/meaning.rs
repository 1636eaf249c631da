//! Descriptions of a source's content without positions, for comparing the source before and after formatting.

use pulldown_cmark::{Event, Parser, Tag, TagEnd, TextMergeStream};
use uavspec_schema::directive::Directive;
use uavspec_schema::documentation::{self, Commentary, ItemDocs};
use uavspec_schema::msg::Dialect;
use uavspec_schema::msg::annotation::Note;
use uavspec_schema::msg::ast::{Comment, Constant, Definition, Field, Item, Line, Part};
use uavspec_schema::msg::statement::Statement;
use uavspec_schema::source::SourceMap;
use uavspec_schema::table::{Cell, Form, Heading, Page, Row, Table, Text, markdown};

use super::table::without_trailing_blank_lines;

/// Describes a definition: its declarations and comments, and the documentation read from them.
pub(super) fn describe_definition(
    sources: &SourceMap,
    definition: &Definition<'_>,
    dialect: Dialect,
) -> Vec<String> {
    let mut parts = Vec::new();
    for part in &definition.parts {
        parts.push(describe_commentary(part, dialect));
        parts.extend(
            part.lines.iter().filter(|line| !line.is_blank()).map(|line| describe_line(sources, line)),
        );
    }
    parts
}

fn describe_commentary(part: &Part<'_>, dialect: Dialect) -> String {
    let Commentary { docs, groups, items, topics } = documentation::read(part, dialect);
    let items: Vec<_> = items.iter().map(|ItemDocs { description, group }| (description, group)).collect();
    let topics: Vec<&str> = topics.iter().map(|(topic, _)| *topic).collect();
    format!("{docs:?} {groups:?} {items:?} {topics:?}")
}

fn describe_line(sources: &SourceMap, line: &Line<'_>) -> String {
    let item = match line.item.as_deref() {
        None => String::new(),
        Some(Item::Field(Field { ty, name, default })) => {
            format!("{} {} {default:?}", sources.slice(ty.span), name.text)
        }
        Some(Item::Constant(Constant { ty, name, value, .. })) => format!("{ty:?} {} = {value:?}", name.text),
    };
    format!("{item} {:?}", line.comment.as_deref().map(describe_comment))
}

fn describe_comment(comment: &Comment<'_>) -> String {
    let text = match &comment.note {
        Some(note) => describe_note(note),
        // White space is significant only in documentation, which is compared separately.
        None => comment.text.split_whitespace().collect::<Vec<_>>().join(" "),
    };
    let directive = comment.directive.map(|Directive { rule, reason, .. }| (rule, reason));
    format!("{text} {directive:?}")
}

/// Describes the note of a declaration. Annotations of different kinds may be in any order.
pub(super) fn describe_note(note: &Note<'_>) -> String {
    let mut statements: Vec<&Statement<'_>> =
        note.annotations.iter().map(|annotation| &annotation.statement).collect();
    statements.sort_by_key(|statement| statement.rank());
    let parameters: Vec<String> = note.parameters.iter().map(describe_note).collect();
    format!("{statements:?} {:?} {parameters:?}", note.text)
}

/// Describes a page: its headings and tables and, for Markdown, all rendered content.
pub(super) fn describe_page(path: &str, text: &str, page: &Page) -> Vec<String> {
    let form = Form::of(path, text);
    let mut parts = vec![format!("{form:?}")];
    parts.extend(page.headings.iter().map(|Heading { level, text }| format!("{level} {:?}", text.as_str())));
    for Table { heading, title, header, rows, .. } in &page.tables {
        parts.push(format!("{heading:?} {:?} {}", title.as_ref().map(Text::as_str), describe_cells(header)));
        parts.extend(rows.iter().map(|Row { cells, .. }| describe_cells(cells)));
    }
    if form == Form::Markdown {
        parts.extend(rendered(text));
    }
    parts
}

fn describe_cells(cells: &[Cell]) -> String {
    let cells: Vec<_> = cells.iter().map(|cell| (cell.text.as_str(), cell.is_merged)).collect();
    format!("{cells:?}")
}

/// The rendered content of a Markdown page, without the alignment of columns.
fn rendered(text: &str) -> Vec<String> {
    // Line endings, and a missing line ending at the end of the file, don't change the content.
    let text = without_trailing_blank_lines(text).replace("\r\n", "\n") + "\n";
    // White space at the end of a heading or cell is not rendered. The text of headings and cells was compared above.
    let mut is_trimmed = false;
    let mut rendered = Vec::new();
    for event in TextMergeStream::new(Parser::new_ext(&text, markdown::OPTIONS)) {
        match &event {
            Event::Start(Tag::TableCell | Tag::Heading { .. }) => is_trimmed = true,
            Event::End(TagEnd::TableCell | TagEnd::Heading(_)) => is_trimmed = false,
            _ => {}
        }
        rendered.push(match event {
            Event::Start(Tag::Table(_)) => "table".to_owned(),
            Event::Text(text) if is_trimmed => format!("{:?}", text.trim()),
            event => format!("{event:?}"),
        });
    }
    rendered
}
