//! The fields of a message, group by group.

use uavspec_schema::translation::MessageText;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Message, MessageId, Type, UorbLayout};

use super::cell::{self, field_link, unit};
use super::enums;
use super::groups::in_groups;
use super::markdown::{Page, Table, anchor, code, href, link, number_column, text_column};
use super::scope::Scope;
use super::site::Part;
use super::words::{self, Word};

/// Writes the fields of a message. `level` is the heading level of groups.
pub(super) fn write(page: &mut Page, scope: Scope<'_, '_>, id: MessageId, level: usize) {
    let message = scope.site.schema.message(id);
    let words = scope.site.words;
    if message.fields.is_empty() {
        page.block(words.get(words::NO_FIELDS));
        return;
    }
    let columns = [
        text_column(words.get(words::FIELD)),
        text_column(words.get(words::TYPE)),
        text_column(words.get(words::UNIT)),
        text_column(words.get(words::VALUES)),
        text_column(words.get(words::DESCRIPTION)),
        number_column(words.get(words::OFFSET)),
    ];
    let mut table = Table::new(&columns);
    // Only messages with a memory layout have offsets.
    let offsets = scope.site.layout(message).map(UorbLayout::offsets).unwrap_or_default();
    for (index, counter) in counters(message).into_iter().enumerate() {
        let offset = offsets.get(&index).map(ToString::to_string).unwrap_or_default();
        table.row(row(scope, id, index, counter, offset));
    }
    let groups: Vec<Option<usize>> = message.fields.iter().map(|field| field.group).collect();
    in_groups(page, scope, table, &groups, level);
}

fn row(
    scope: Scope<'_, '_>,
    id: MessageId,
    index: usize,
    counter: Option<usize>,
    offset: String,
) -> [String; 6] {
    let message = scope.site.schema.message(id);
    let field = &message.fields[index];
    let place = anchor(&scope.site.anchor(id, Part::Field(index)));
    let scope = scope.at(Part::Field(index));
    [
        place + &code(&field.name),
        type_cell(scope, message, field.ty),
        unit(field.unit.as_deref()),
        values(scope, id, index, counter).join("<br>"),
        scope.inline_of(MessageText::Field(index)),
        offset,
    ]
}

/// A type. A message type links to the page of the message.
fn type_cell(scope: Scope<'_, '_>, message: &Message, ty: Type) -> String {
    let text = code(&scope.site.schema.type_text(message, ty));
    match ty.element {
        Element::Message(nested) => link(&text, &href(scope.from, scope.site.path(nested), "")),
        Element::Scalar(_) | Element::Text(_) | Element::String { .. } => text,
    }
}

/// Facts about the values of a field, one per line.
fn values(scope: Scope<'_, '_>, id: MessageId, index: usize, counter: Option<usize>) -> Vec<String> {
    let message = scope.site.schema.message(id);
    let field = &message.fields[index];
    let words = scope.site.words;
    let mut lines = Vec::new();
    lines.extend(enums::of_field(scope, field));
    lines.extend(
        field
            .constraints
            .iter()
            .filter_map(|found| cell::constraint(scope, found, MessageText::Constraint(index, found.kind))),
    );
    lines.extend(field.attributes().map(|(attribute, _)| {
        let text = scope.inline_of(MessageText::Attribute(index, attribute));
        words.fill(Word::of(attribute), &[(attribute.name, &text)])
    }));
    let default = |value: &Value| words.fill(words::DEFAULT, &[("value", &code(&value.to_string()))]);
    lines.extend(field.default.as_ref().map(default));
    lines.extend(field.counts.map(|array| count(scope, id, array)));
    let first =
        |counter| words.fill(words::FIRST_IN_USE, &[("counter", &field_link(scope, id, (id, counter)))]);
    lines.extend(counter.map(first));
    if field.is_text() {
        lines.push(words.get(words::TEXT).to_owned());
    }
    lines
}

/// For each field, the index of the field that counts its used entries, if there is one.
fn counters(message: &Message) -> Vec<Option<usize>> {
    let mut counters = vec![None; message.fields.len()];
    for (index, field) in message.fields.iter().enumerate() {
        if let Some(array) = field.counts {
            counters[array] = Some(index);
        }
    }
    counters
}

/// The description of a field that counts the used entries of `array`.
fn count(scope: Scope<'_, '_>, id: MessageId, array: usize) -> String {
    let words = scope.site.words;
    let link = field_link(scope, id, (id, array));
    match scope.site.schema.message(id).fields[array].ty.max_length() {
        Some(max) => words.fill(words::IN_USE_AT_MOST, &[("array", &link), ("most", &max.to_string())]),
        None => words.fill(words::IN_USE, &[("array", &link)]),
    }
}
