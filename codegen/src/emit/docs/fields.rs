//! The fields of a message, group by group.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::enums::{self, field_link};
use super::markdown::{
    Page, Table, anchor, code, gist, href, inline, link, number_column, text_column, unbroken,
};
use super::scope::Scope;
use super::site::Part;
use crate::schema::{Docs, Element, Form, Message, MessageId, Range, Shape, Special, Type};
use crate::unit;
use crate::value::Value;

/// Longest heading of a group, in characters; what is longer is a text below its start.
const MAX_HEADING: usize = 100;

/// Writes the fields of a message; the headings of groups are of `level`.
pub(super) fn write(page: &mut Page, scope: Scope<'_, '_>, id: MessageId, level: usize) {
    let message = scope.site.schema.message(id);
    if message.fields.is_empty() {
        page.block("None.");
        return;
    }
    let columns = [
        text_column("Field"),
        text_column("Type"),
        text_column("Unit"),
        text_column("Values"),
        text_column("Description"),
        number_column("Offset"),
    ];
    let mut table = Table::new(&columns);
    let facts = counters(message).into_iter().zip(offsets(scope, message));
    for (index, (counter, offset)) in facts.enumerate() {
        table.row(row(scope, id, index, counter, offset));
    }
    let groups: Vec<Option<usize>> = message.fields.iter().map(|field| field.group).collect();
    in_groups(page, scope, table, &groups, &message.groups, level);
}

/// Writes a table in parts, one for each run of rows of the same group.
pub(super) fn in_groups(
    page: &mut Page,
    scope: Scope<'_, '_>,
    table: Table,
    groups: &[Option<usize>],
    docs: &[Docs],
    level: usize,
) {
    let runs: Vec<&[Option<usize>]> = groups.chunk_by(|left, right| left == right).collect();
    let tables = table.split(runs.iter().map(|run| run.len()));
    for (index, (run, table)) in runs.iter().zip(tables).enumerate() {
        match run[0].map(|group| &docs[group]) {
            Some(docs) => group_heading(page, scope, docs, level),
            None if index > 0 => page.heading(level, "Others"),
            None => {}
        }
        page.table(&table);
    }
}

fn group_heading(page: &mut Page, scope: Scope<'_, '_>, docs: &Docs, level: usize) {
    let is_short = docs.summary.chars().count() <= MAX_HEADING;
    let heading = if is_short { docs.summary.clone() } else { gist(&docs.summary, MAX_HEADING) };
    page.heading(level, &inline(heading.trim_end_matches(['.', ':'])));
    page.block(&scope.block(if is_short { &docs.description } else { &docs.summary }));
    if !is_short {
        page.block(&scope.block(&docs.description));
    }
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
        scope.inline(&field.description),
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
    let mut lines = Vec::new();
    lines.extend(enums::of_field(scope, field));
    lines.extend(field.range.as_ref().and_then(range));
    lines.extend(field.invalid.as_ref().map(|special| meaning(scope, special, "no data")));
    lines.extend(field.uncontrolled.as_ref().map(|special| meaning(scope, special, "not controlled")));
    lines.extend(field.frame.as_deref().map(|frame| format!("frame: {}", scope.inline(frame))));
    lines.extend(field.default.as_ref().map(|value| format!("default {}", code(&value.to_string()))));
    lines.extend(field.counts.map(|array| count(scope, id, array)));
    lines
        .extend(counter.map(|counter| format!("in use: the first {}", field_link(scope, id, (id, counter)))));
    if matches!(scope.site.schema.package_of(message).form, Form::Msg(dialect) if field.is_text(dialect)) {
        lines.push("text".to_owned());
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
    let most = match scope.site.schema.message(id).fields[array].ty.shape {
        Shape::Array(most) | Shape::Bounded(most) => format!(", at most {most}"),
        Shape::Single | Shape::Sequence => String::new(),
    };
    format!("entries of {} in use{most}", field_link(scope, id, (id, array)))
}

/// Bounds in words; nothing where there are none.
pub(super) fn range(range: &Range) -> Option<String> {
    let finite = |bound: &Option<Value>| {
        bound
            .as_ref()
            .filter(|value| !matches!(value, Value::Float(float) if float.is_infinite()))
            .map(number)
    };
    match (finite(&range.low), finite(&range.high)) {
        (Some(low), Some(high)) => Some(unbroken(&format!("{low} to {high}"))),
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

/// A value with a meaning of its own, and when it applies.
pub(super) fn meaning(scope: Scope<'_, '_>, special: &Special, meaning: &str) -> String {
    let value = special.value.as_ref().map_or_else(|| "empty".to_owned(), |value| code(&value.to_string()));
    let meaning = format!("{value}:&nbsp;{}", unbroken(meaning));
    let text = scope.inline(&special.text);
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
