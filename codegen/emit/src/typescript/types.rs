//! Types, keys and values in TypeScript syntax.

use uavspec_schema::value::Value;

use crate::binding::{Type, float, identifier, quoted};

/// The largest integer up to which a `number` represents all integers exactly.
const GREATEST_EXACT: i128 = (1 << 53) - 1;

/// Formats a type.
pub(super) fn ty(found: &Type) -> String {
    match found {
        Type::Any => "unknown".to_owned(),
        Type::Null => "null".to_owned(),
        Type::Boolean => "boolean".to_owned(),
        Type::Integer | Type::Number => "number".to_owned(),
        Type::String => "string".to_owned(),
        Type::Strings { values, is_open } => {
            let mut all: Vec<String> = values.iter().map(|value| quoted(value)).collect();
            all.extend(is_open.then(|| any_other("string", values.is_empty())));
            union(&all)
        }
        Type::Integers { values, is_open } => integers(values, *is_open),
        Type::Set(name) => name.clone(),
        Type::Named { module, name } | Type::Enumeration { module, name } => match module {
            Some(module) => format!("{module}.{name}"),
            None => name.clone(),
        },
        Type::List(element) if needs_brackets(element) => format!("({})[]", ty(element)),
        Type::List(element) => format!("{}[]", ty(element)),
        Type::Map(value) => format!("{{ [key: string]: {} }}", ty(value)),
        Type::Tuple(elements) => {
            let elements = elements.iter().map(|(name, is_required, element)| {
                format!("{}{}: {}", identifier(name), if *is_required { "" } else { "?" }, ty(element))
            });
            format!("[{}]", elements.collect::<Vec<_>>().join(", "))
        }
        Type::Either(alternatives) => union(&alternatives.iter().map(ty).collect::<Vec<_>>()),
    }
}

/// All values of a primitive type. If there are literals, `& {}` keeps them from being absorbed into the primitive
/// type.
pub(super) fn any_other(primitive: &str, has_no_literals: bool) -> String {
    if has_no_literals { primitive.to_owned() } else { format!("({primitive} & {{}})") }
}

fn union(alternatives: &[String]) -> String {
    if alternatives.is_empty() { "never".to_owned() } else { alternatives.join(" | ") }
}

/// Formats a set of integers. Values that a `number` can't represent exactly have no literal type.
fn integers(values: &[i64], is_open: bool) -> String {
    let exact: Vec<String> =
        values.iter().filter(|value| is_exact((**value).into())).map(ToString::to_string).collect();
    if !is_open && exact.len() < values.len() {
        return "number".to_owned();
    }
    let has_no_literals = exact.is_empty();
    let other = is_open.then(|| any_other("number", has_no_literals));
    union(&exact.into_iter().chain(other).collect::<Vec<_>>())
}

fn needs_brackets(element: &Type) -> bool {
    match element {
        Type::Either(alternatives) => alternatives.len() > 1 || alternatives.iter().any(needs_brackets),
        Type::Strings { values, is_open } => values.len() + usize::from(*is_open) > 1,
        Type::Integers { values, is_open } => values.len() + usize::from(*is_open) > 1,
        _ => false,
    }
}

/// The key of an object or an interface.
pub(super) fn key(name: &str) -> String {
    if name == "__proto__" {
        // Write `__proto__` in brackets. As a plain key, it would set the prototype of the object.
        return "[\"__proto__\"]".to_owned();
    }
    let is_plain = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    if is_plain { name.to_owned() } else { quoted(name) }
}

/// Formats a value of a definition.
pub(super) fn value(found: &Value) -> String {
    match found {
        Value::Bool(value) => value.to_string(),
        Value::Int(value) if is_exact(*value) => value.to_string(),
        Value::Int(value) => format!("{value}n"),
        Value::Float(value) => float(*value).unwrap_or_else(|| match value {
            value if value.is_nan() => "NaN".to_owned(),
            value if *value > 0.0 => "Infinity".to_owned(),
            _ => "-Infinity".to_owned(),
        }),
        Value::Text(text) => quoted(text),
        Value::List(values) => format!("[{}]", values.iter().map(value).collect::<Vec<_>>().join(", ")),
    }
}

/// The narrowest type of a value.
pub(super) fn type_of_value(found: &Value) -> String {
    match found {
        Value::Float(value) if !value.is_finite() => "number".to_owned(),
        Value::List(values) => {
            format!("readonly [{}]", values.iter().map(type_of_value).collect::<Vec<_>>().join(", "))
        }
        other => value(other),
    }
}

/// True if a `number` represents the integer exactly.
pub(super) fn is_exact(value: i128) -> bool {
    value.abs() <= GREATEST_EXACT
}
