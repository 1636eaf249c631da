//! Completion: types, units, annotations, prefixes of enums, error codes and rules.
//!
//! The text before the cursor alone selects the kind of items, because a line that is being typed often can't be parsed.
//! In event metadata, types are completed between two quotes, which editors insert together.

pub(super) mod item;
mod page;

use std::collections::BTreeMap;

use lsp_types::{CompletionItem, CompletionItemKind, CompletionItemTextEdit, InsertTextFormat, TextEdit};
use uavspec_lint::RULES;
use uavspec_runtime::Scalar;
use uavspec_schema::msg::attribute::ATTRIBUTES;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::resolve::default_topic;
use uavspec_schema::source::stem;
use uavspec_schema::{Form, Message, Shape, directive};

use self::item::{Item, annotations, open_bracket, units, word_start};
use super::events;
use super::snapshot::Document;

/// Characters after which editors ask for items.
pub(super) const TRIGGERS: [&str; 6] = ["[", "@", "/", ".", " ", "\""];

/// The items at a byte offset.
/// `with_snippets` is true if the editor supports placeholders.
pub(super) fn complete(document: &Document<'_>, offset: usize, with_snippets: bool) -> Vec<CompletionItem> {
    let line = document.lines.line_of(offset);
    let start = document.lines.start(line);
    let before = &document.lines.text()[start..offset];
    let (from, items) = match document.form() {
        Some(Form::Msg(dialect)) => of_definition(document, dialect, before, offset),
        Some(Form::Table) => page::items(document, line, before),
        Some(Form::Events) => events::items(document, offset).unwrap_or_default(),
        None => return Vec::new(),
    };
    let range = document.lines.range(start + from..offset);
    let item = |item: Item| CompletionItem {
        kind: Some(item.kind),
        detail: Some(item.detail).filter(|detail| !detail.is_empty()),
        filter_text: Some(item.label.clone()),
        insert_text_format: item
            .snippet
            .as_ref()
            .filter(|_| with_snippets)
            .map(|_| InsertTextFormat::Snippet),
        text_edit: Some(CompletionItemTextEdit::TextEdit(TextEdit {
            range,
            new_text: item.snippet.filter(|_| with_snippets).unwrap_or_else(|| item.label.clone()),
        })),
        label: item.label,
        ..CompletionItem::default()
    };
    items.into_iter().map(item).collect()
}

/// The items in a `.msg`, `.srv` or `.action` file, and the start of the text that they replace.
fn of_definition(
    document: &Document<'_>,
    dialect: Dialect,
    before: &str,
    offset: usize,
) -> (usize, Vec<Item>) {
    let Some(hash) = before.find('#') else {
        let from = before.len() - before.trim_start().len();
        let is_type = !before[from..].contains(char::is_whitespace);
        return (from, if is_type { types(document, dialect) } else { Vec::new() });
    };
    let comment = &before[hash + 1..];
    if let Some(at) = comment.rfind(directive::MARK) {
        let rule = hash + 1 + at + directive::MARK.len();
        let word = before[rule..].trim_start();
        let rules = RULES.iter().map(|rule| Item::new(rule.id, CompletionItemKind::Value, rule.statement));
        return (before.len() - word.len(), if word.contains(' ') { Vec::new() } else { rules.collect() });
    }
    if dialect == Dialect::Px4
        && before[..hash].trim().is_empty()
        && comment.trim_start().starts_with("TOPICS ")
    {
        let name = stem(document.snapshot.loaded.sources.path(document.id));
        let topic = Item::new(default_topic(name), CompletionItemKind::Value, "the default topic");
        return (word_start(before), vec![topic]);
    }
    match open_bracket(comment) {
        Some(open) => {
            let (from, items) = in_brackets(document, offset, &comment[open..]);
            (hash + 1 + open + from, items)
        }
        None => (before.len(), Vec::new()),
    }
}

/// The built-in types and the messages of the package. For ROS 2, also the messages of other packages.
fn types(document: &Document<'_>, dialect: Dialect) -> Vec<Item> {
    let schema = &document.snapshot.schema;
    let is_known = |scalar: &Scalar| dialect == Dialect::Ros2 || *scalar != Scalar::Byte;
    let built_in = Scalar::ALL.into_iter().filter(is_known).map(Scalar::name);
    let strings = ["string", "wstring"].into_iter().filter(|_| dialect == Dialect::Ros2);
    let mut items: Vec<Item> = built_in
        .chain(strings)
        .map(|name| Item::new(name, CompletionItemKind::Keyword, "built-in type"))
        .collect();
    let own = document.package_index();
    for (at, package) in schema.packages.iter().enumerate() {
        let is_own = own == Some(at);
        if !is_own && (dialect == Dialect::Px4 || package.messages.is_empty()) {
            continue;
        }
        let messages = package.messages.iter().map(|id| schema.message(*id));
        items.extend(messages.filter(|message| message.kind == Kind::Message).map(|message| {
            let name =
                if is_own { message.name.clone() } else { format!("{}/{}", package.name, message.name) };
            Item::new(name, CompletionItemKind::Struct, message.docs.summary.clone())
        }));
    }
    items
}

/// The items after an opening bracket, and the start of the text that they replace.
fn in_brackets(document: &Document<'_>, offset: usize, content: &str) -> (usize, Vec<Item>) {
    let Some(annotation) = content.strip_prefix('@') else {
        let items = units().chain(annotations());
        return (0, if content.contains(',') { Vec::new() } else { items.collect() });
    };
    let Some((name, argument)) = annotation.split_once(' ') else { return (0, annotations()) };
    let from = content.len() - argument.len();
    let word = from + word_start(argument);
    match name {
        "enum" | "flags" => {
            let (word, owner) = match argument[word - from..].rsplit_once('.') {
                Some((owner, _)) => (word + owner.len() + 1, Some(owner)),
                None => (word, None),
            };
            (word, prefixes(document, offset, owner))
        }
        "count" => (word, arrays(document, offset)),
        "invalid" => (word, vec![Item::new("NaN", CompletionItemKind::Value, "not a number")]),
        _ => {
            let attribute = ATTRIBUTES.iter().find(|attribute| attribute.name == name);
            let values = attribute.map_or(&[][..], |attribute| attribute.bare).iter();
            (word, values.map(|value| Item::new(*value, CompletionItemKind::Value, "")).collect())
        }
    }
}

/// The prefixes of constants in this message or in `owner`, and the other messages that define constants.
fn prefixes(document: &Document<'_>, offset: usize, owner: Option<&str>) -> Vec<Item> {
    let schema = &document.snapshot.schema;
    let Some(package) = document.package_index().map(|at| &schema.packages[at]) else { return Vec::new() };
    let messages = || package.messages.iter().map(|id| schema.message(*id));
    if let Some(owner) = owner {
        return messages().find(|message| message.name == owner).map(prefixes_of).unwrap_or_default();
    }
    let mut items = message_at(document, offset).map(prefixes_of).unwrap_or_default();
    let others = messages().filter(|message| !message.constants.is_empty());
    items.extend(others.map(|message| {
        Item::new(format!("{}.", message.name), CompletionItemKind::Struct, "constants of another message")
    }));
    items
}

/// The prefixes that at least two constants of a message share. Each prefix ends before a `_`.
fn prefixes_of(message: &Message) -> Vec<Item> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for constant in &message.constants {
        for (at, _) in constant.name.match_indices('_') {
            *counts.entry(&constant.name[..at]).or_default() += 1;
        }
    }
    counts.retain(|prefix, count| *count > 1 && !prefix.is_empty());
    let item = |(prefix, count)| Item::new(prefix, CompletionItemKind::Enum, format!("{count} constants"));
    counts.into_iter().map(item).collect()
}

/// The arrays of the message at a byte offset.
fn arrays(document: &Document<'_>, offset: usize) -> Vec<Item> {
    let Some(message) = message_at(document, offset) else { return Vec::new() };
    let arrays = message.fields.iter().filter(|field| field.ty.shape != Shape::Single);
    let ty = |ty| document.snapshot.schema.type_text(message, ty);
    arrays.map(|field| Item::new(&field.name, CompletionItemKind::Field, ty(field.ty))).collect()
}

/// The message, or the part of a service or action, at a byte offset.
fn message_at<'d>(document: &'d Document<'_>, offset: usize) -> Option<&'d Message> {
    let id = document.message_at(document.span(offset..offset))?;
    Some(document.snapshot.schema.message(id))
}
