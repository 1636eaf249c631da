//! The fields of a message, group by group.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::enums::{self, field_link};
use super::language::marked;
use super::markdown::{
    Page, Table, anchor, code, gist, href, inline, link, number_column, text_column, unbroken,
};
use super::message::heading;
use super::scope::Scope;
use super::site::Part;
use super::words::{self, Word, Words};
use crate::schema::{Element, Form, Message, MessageId, Range, Shape, Special, Type};
use crate::translation::MessageText;
use crate::unit;
use crate::value::Value;

/// Longest heading of a group, in characters; what is longer is a text below its start.
const MAX_HEADING: usize = 100;

/// Writes the fields of a message; the headings of groups are of `level`.
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
    let facts = counters(message).into_iter().zip(offsets(scope, message));
    for (index, (counter, offset)) in facts.enumerate() {
        table.row(row(scope, id, index, counter, offset));
    }
    let groups: Vec<Option<usize>> = message.fields.iter().map(|field| field.group).collect();
    in_groups(page, scope, table, &groups, level);
}

/// Writes a table in parts, one for each run of rows of the same group.
pub(super) fn in_groups(
    page: &mut Page,
    scope: Scope<'_, '_>,
    table: Table,
    groups: &[Option<usize>],
    level: usize,
) {
    let runs: Vec<&[Option<usize>]> = groups.chunk_by(|left, right| left == right).collect();
    let tables = table.split(runs.iter().map(|run| run.len()));
    for (index, (run, table)) in runs.iter().zip(tables).enumerate() {
        match run[0] {
            Some(group) => group_heading(page, scope, group, level),
            None if index > 0 => heading(page, scope.site.words, level, words::OTHERS),
            None => {}
        }
        page.table(&table);
    }
}

fn group_heading(page: &mut Page, scope: Scope<'_, '_>, group: usize, level: usize) {
    let said = scope.site.said_of(scope.message, MessageText::Group(group));
    let heading = marked(&inline(&heading_text(said.text)), said.tag);
    if scope.site.language.is_some() {
        let english = MessageText::Group(group).of(scope.site.schema.message(scope.message));
        page.heading_for(level, &heading, &heading_text(english));
    } else {
        page.heading(level, &heading);
    }
    if said.text.chars().count() > MAX_HEADING {
        page.block(&scope.block_of(MessageText::Group(group)));
    }
    page.block(&scope.block_of(MessageText::GroupDescription(group)));
}

/// The heading of a group that a text stands above.
fn heading_text(text: &str) -> String {
    let short = if text.chars().count() <= MAX_HEADING { text.to_owned() } else { gist(text, MAX_HEADING) };
    short.trim_end_matches(['.', ':']).to_owned()
}

/// Where each field lies in the memory layout, where there is one.
fn offsets<'s>(scope: Scope<'_, 's>, message: &'s Message) -> Vec<String> {
    let mut offsets = vec![String::new(); message.fields.len()];
    for slot in scope.site.layout(message).into_iter().flat_map(|layout| &layout.slots) {
        if let Some(field) = slot.field {
            offsets[field] = slot.offset.to_string();
        }
    }
    offsets
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

/// A type, which leads to the message that it names.
fn type_cell(scope: Scope<'_, '_>, message: &Message, ty: Type) -> String {
    let text = code(&scope.site.schema.type_text(message, ty));
    match ty.element {
        Element::Message(nested) => link(&text, &href(scope.from, scope.site.path(nested), "")),
        Element::Scalar(_) | Element::String { .. } => text,
    }
}

/// The symbol of a unit; nothing where there is none.
pub(super) fn unit(symbol: Option<&str>) -> String {
    inline(symbol.filter(|symbol| *symbol != unit::NONE).unwrap_or_default())
}

/// What is said of the values of a field, a line each.
fn values(scope: Scope<'_, '_>, id: MessageId, index: usize, counter: Option<usize>) -> Vec<String> {
    let message = scope.site.schema.message(id);
    let field = &message.fields[index];
    let words = scope.site.words;
    let mut lines = Vec::new();
    lines.extend(enums::of_field(scope, field));
    lines.extend(field.range.as_ref().and_then(|bounds| range(words, bounds)));
    let special = |special: &Option<Special>, text, word| {
        special.as_ref().map(|special| meaning(scope, special, text, word))
    };
    lines.extend(special(&field.invalid, MessageText::Invalid(index), words::NO_DATA));
    lines.extend(special(&field.uncontrolled, MessageText::Uncontrolled(index), words::NOT_CONTROLLED));
    if field.frame.is_some() {
        lines.push(words.fill(words::FRAME, &[("frame", &scope.inline_of(MessageText::Frame(index)))]));
    }
    let default = |value: &Value| words.fill(words::DEFAULT, &[("value", &code(&value.to_string()))]);
    lines.extend(field.default.as_ref().map(default));
    lines.extend(field.counts.map(|array| count(scope, id, array)));
    let first =
        |counter| words.fill(words::FIRST_IN_USE, &[("counter", &field_link(scope, id, (id, counter)))]);
    lines.extend(counter.map(first));
    if matches!(scope.site.schema.package_of(message).form, Form::Msg(dialect) if field.is_text(dialect)) {
        lines.push(words.get(words::TEXT).to_owned());
    }
    lines
}

/// By field, the one that counts its entries in use.
fn counters(message: &Message) -> Vec<Option<usize>> {
    let mut counters = vec![None; message.fields.len()];
    for (index, field) in message.fields.iter().enumerate() {
        if let Some(array) = field.counts {
            counters[array] = Some(index);
        }
    }
    counters
}

/// What a field says of the array whose entries in use it counts.
fn count(scope: Scope<'_, '_>, id: MessageId, array: usize) -> String {
    let words = scope.site.words;
    let link = field_link(scope, id, (id, array));
    match scope.site.schema.message(id).fields[array].ty.shape {
        Shape::Array(most) | Shape::Bounded(most) => {
            words.fill(words::IN_USE_AT_MOST, &[("array", &link), ("most", &most.to_string())])
        }
        Shape::Single | Shape::Sequence => words.fill(words::IN_USE, &[("array", &link)]),
    }
}

/// Bounds in words; nothing where there are none.
pub(super) fn range(words: Words, range: &Range) -> Option<String> {
    let finite = |bound: &Option<Value>| {
        bound
            .as_ref()
            .filter(|value| !matches!(value, Value::Float(float) if float.is_infinite()))
            .map(number)
    };
    match (finite(&range.low), finite(&range.high)) {
        (Some(low), Some(high)) => {
            Some(unbroken(&words.fill(words::RANGE, &[("low", &low), ("high", &high)])))
        }
        (Some(low), None) => Some(unbroken(&format!("≥ {low}"))),
        (None, Some(high)) => Some(unbroken(&format!("≤ {high}"))),
        (None, None) => None,
    }
}

/// A bound; multiples of π as such.
fn number(value: &Value) -> String {
    let known = [(PI, "π"), (FRAC_PI_2, "π/2"), (TAU, "2π")];
    let name = match value {
        Value::Float(float) => known.iter().find(|(multiple, _)| multiple.to_bits() == float.abs().to_bits()),
        _ => None,
    };
    let sign = if value.as_f64().is_some_and(|value| value < 0.0) { "-" } else { "" };
    name.map_or_else(|| inline(&value.to_string()), |(_, name)| format!("{sign}{name}"))
}

/// A value with a meaning of its own, and when it applies: `text` says it in words.
pub(super) fn meaning(scope: Scope<'_, '_>, special: &Special, text: MessageText, meaning: Word) -> String {
    let words = scope.site.words;
    let empty = || words.get(words::EMPTY).to_owned();
    let value = special.value.as_ref().map_or_else(empty, |value| code(&value.to_string()));
    let meaning = format!("{value}:&nbsp;{}", unbroken(words.get(meaning)));
    let text = scope.inline_of(text);
    if text.is_empty() { meaning } else { format!("{meaning} ({text})") }
}

/// The value of a constant or default; texts as code.
pub(super) fn value_cell(value: &Value) -> String {
    match value {
        Value::Bool(_) | Value::Int(_) | Value::Float(_) => value.to_string(),
        Value::Text(_) | Value::List(_) => code(&value.to_string()),
    }
}

/// The type of a constant.
pub(super) fn constant_type(scope: Scope<'_, '_>, message: &Message, element: Element) -> String {
    code(&scope.site.schema.type_text(message, Type { element, shape: Shape::Single }))
}
