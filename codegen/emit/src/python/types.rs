//! Types and values in Python syntax.

use std::collections::BTreeSet;

use uavspec_schema::value::Value;

use super::uses::Uses;
use crate::binding::{Type, float, is_python_keyword, quoted};

/// Formats a type. Names are quoted, because the named types may be declared later.
pub(super) fn ty(found: &Type, uses: &mut Uses) -> String {
    match found {
        Type::Any => {
            uses.typing.insert("Any");
            "Any".to_owned()
        }
        Type::Null => "None".to_owned(),
        Type::Boolean => "bool".to_owned(),
        Type::Integer => "int".to_owned(),
        Type::Number => "float".to_owned(),
        Type::String => "str".to_owned(),
        Type::Strings { values, is_open } => {
            let literals: Vec<String> = values.iter().map(|value| quoted(value)).collect();
            values_of("str", &literals, *is_open, uses)
        }
        Type::Integers { values, is_open } => {
            let literals: Vec<String> = values.iter().map(ToString::to_string).collect();
            values_of("int", &literals, *is_open, uses)
        }
        Type::Set(name) => reference(None, name),
        Type::Named { module, name } => reference(module.as_deref(), name),
        Type::List(element) => format!("list[{}]", ty(element, uses)),
        Type::Map(value) => format!("dict[str, {}]", ty(value, uses)),
        // `json.loads` returns a list. The type of a list can't distinguish positions.
        Type::Tuple(elements) => {
            let elements = elements.iter().map(|(_, _, element)| element.clone()).collect();
            format!("list[{}]", ty(&Type::Either(elements), uses))
        }
        Type::Either(_) | Type::Enumeration { .. } => {
            let alternatives = alternatives(found, uses);
            union(alternatives, uses)
        }
    }
}

/// A reference to a declaration.
fn reference(module: Option<&str>, name: &str) -> String {
    module.map_or_else(|| format!("\"{name}\""), |module| format!("\"{module}.{name}\""))
}

/// The alternatives of a union. `json.loads` returns the value of an enum as an `int`.
fn alternatives(found: &Type, uses: &mut Uses) -> Vec<String> {
    match found {
        Type::Either(types) => types.iter().flat_map(|inner| alternatives(inner, uses)).collect(),
        Type::Enumeration { module, name } => vec![reference(module.as_deref(), name), "int".to_owned()],
        other => vec![ty(other, uses)],
    }
}

fn values_of(primitive: &str, literals: &[String], is_open: bool, uses: &mut Uses) -> String {
    if literals.is_empty() {
        return primitive.to_owned();
    }
    uses.typing.insert("Literal");
    let literal = format!("Literal[{}]", literals.join(", "));
    if is_open { union(vec![literal, primitive.to_owned()], uses) } else { literal }
}

/// Formats a union of the distinct alternatives.
fn union(mut alternatives: Vec<String>, uses: &mut Uses) -> String {
    let mut known = BTreeSet::new();
    alternatives.retain(|text| known.insert(text.clone()));
    if alternatives.len() == 1 {
        return alternatives.remove(0);
    }
    if alternatives.is_empty() {
        // An empty tuple has no element type.
        uses.typing.insert("Any");
        return "Any".to_owned();
    }
    uses.typing.insert("Union");
    format!("Union[{}]", alternatives.join(", "))
}

/// Formats a value of a definition.
pub(super) fn value(found: &Value) -> String {
    match found {
        Value::Bool(true) => "True".to_owned(),
        Value::Bool(false) => "False".to_owned(),
        Value::Int(value) => value.to_string(),
        Value::Float(value) => float(*value).unwrap_or_else(|| format!("float(\"{value}\")").to_lowercase()),
        Value::Text(text) => quoted(text),
        Value::List(values) => format!("[{}]", values.iter().map(value).collect::<Vec<_>>().join(", ")),
    }
}

/// True if a key can be an attribute of a class. Python mangles names that start with `__`.
pub(super) fn is_attribute(key: &str) -> bool {
    key.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && !key.starts_with("__")
        && !is_python_keyword(key)
}

/// The names used in a type.
pub(super) fn words(ty: &str) -> impl Iterator<Item = &str> {
    ty.split(|c: char| !c.is_ascii_alphanumeric() && c != '_')
}
