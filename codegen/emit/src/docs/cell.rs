//! Contents of table cells: values, types, ranges, and links to fields and commands.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use uavspec_schema::translation::MessageText;
use uavspec_schema::value::Value;
use uavspec_schema::{
    Constant, Constraint, Element, Message, MessageId, Parameter, Range, Shape, Stated, Type, unit,
};

use super::markdown::{code, inline, link, unbroken};
use super::scope::Scope;
use super::site::{FieldRef, Part};
use super::words::{self, Word, Words};

/// The symbol of a unit, or an empty string.
pub(super) fn unit(symbol: Option<&str>) -> String {
    inline(symbol.filter(|symbol| *symbol != unit::NONE).unwrap_or_default())
}

/// Formats a range. Returns `None` if neither bound is finite.
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

/// Formats a bound. Common multiples of π are written with the symbol π.
fn number(value: &Value) -> String {
    let known = [(PI, "π"), (FRAC_PI_2, "π/2"), (TAU, "2π")];
    let name = match value {
        Value::Float(float) => known.iter().find(|(multiple, _)| multiple.to_bits() == float.abs().to_bits()),
        _ => None,
    };
    let sign = if value.as_f64().is_some_and(|value| value < 0.0) { "-" } else { "" };
    name.map_or_else(|| inline(&value.to_string()), |(_, name)| format!("{sign}{name}"))
}

/// Formats the values that a constraint allows, or its special value followed by the description `text`. Returns `None`
/// if all values are valid.
pub(super) fn constraint(scope: Scope<'_, '_>, constraint: &Constraint, text: MessageText) -> Option<String> {
    let words = scope.site.words;
    let word = Word::of_constraint(constraint.kind);
    if constraint.is_special() {
        return Some(meaning(scope, constraint, text, word));
    }
    match &constraint.stated {
        Stated::Range(bounds) => range(words, bounds),
        Stated::Value(value) => Some(words.fill(word, &[("value", &number(value))])),
        Stated::Empty => Some(words.get(word).to_owned()),
    }
}

/// A value with a special meaning, followed by the description `text`.
pub(super) fn meaning(
    scope: Scope<'_, '_>,
    constraint: &Constraint,
    text: MessageText,
    meaning: Word,
) -> String {
    let words = scope.site.words;
    let empty = || words.get(words::EMPTY).to_owned();
    let value = constraint.stated.value().map_or_else(empty, |value| code(&value.to_string()));
    let meaning = format!("{value}:&nbsp;{}", unbroken(words.get(meaning)));
    let text = scope.inline_of(text);
    if text.is_empty() { meaning } else { format!("{meaning} ({text})") }
}

/// The value of a constant or default. Text is formatted as code.
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

/// A link to a field of the same message or another one.
pub(super) fn field_link(scope: Scope<'_, '_>, own: MessageId, (id, index): FieldRef) -> String {
    let schema = scope.site.schema;
    let message = schema.message(id);
    let field = &message.fields[index].name;
    let text = if id == own {
        code(field)
    } else if message.package == scope.package {
        code(&format!("{}.{field}", message.name))
    } else {
        code(&format!("{}/{}.{field}", schema.package_of(message).name, message.name))
    };
    link(&text, &scope.site.href(scope.from, id, Part::Field(index)))
}

/// The name of a constant. If the constant has parameters, the name links to them.
pub(super) fn name_with_parameters(constant: &Constant) -> String {
    let name = code(&constant.name);
    if has_parameters(constant) { link(&name, &format!("#{}", command_anchor(constant))) } else { name }
}

pub(super) fn command_anchor(constant: &Constant) -> String {
    format!("command-{}", constant.name.to_ascii_lowercase())
}

pub(super) fn has_parameters(constant: &Constant) -> bool {
    !constant.parameters.iter().all(Parameter::is_unused)
}
