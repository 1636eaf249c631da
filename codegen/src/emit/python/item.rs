//! A declaration as Python writes it.

use super::text;
use super::types::{is_attribute, ty, value, words};
use super::uses::Uses;
use crate::emit::binding::{Declaration, Kind, Named, Property, quoted};
use crate::value::Value;

const INDENT: &str = "    ";

/// The text of a declaration.
pub(super) fn declaration(declaration: &Declaration, uses: &mut Uses) -> String {
    let Declaration { name, text: said, kind } = declaration;
    match kind {
        Kind::Record { properties, .. } => record(name, said, properties, uses),
        Kind::Alias(aliased) => {
            uses.recent.insert("TypeAlias");
            let aliased = ty(aliased, uses);
            format!("{name}: TypeAlias = {aliased}\n{}", text::docstring(said, ""))
        }
        Kind::Enumeration { is_flags, members } => {
            // Python takes negative flags for all bits but some.
            let is_negative =
                members.iter().any(|member| matches!(member.value, Value::Int(value) if value < 0));
            let base = if *is_flags && !is_negative {
                uses.is_flags_used = true;
                "IntFlag"
            } else {
                uses.is_open_enum_used = true;
                "OpenIntEnum"
            };
            class(name, &format!("({base})"), said, &named(members, " = "))
        }
        Kind::Constants(members) => {
            uses.typing.insert("Final");
            class(name, "", said, &named(members, ": Final = "))
        }
        Kind::Messages(_) => String::new(),
    }
}

/// A class with its text and its members.
pub(super) fn class(name: &str, bases: &str, said: &str, members: &[String]) -> String {
    let body: String = members.iter().map(|member| format!("\n{member}")).collect();
    let docstring = text::docstring(said, INDENT);
    let empty = if body.is_empty() && docstring.is_empty() { "    pass\n" } else { "" };
    format!("class {name}{bases}:\n{docstring}{body}{empty}")
}

/// Names of values, each with what is said of it.
pub(super) fn named(members: &[Named], separator: &str) -> Vec<String> {
    let member = |member: &Named| {
        let docstring = text::docstring(&member.text, INDENT);
        format!("{INDENT}{}{separator}{}\n{docstring}", member.name, value(&member.value))
    };
    members.iter().map(member).collect()
}

fn record(name: &str, said: &str, properties: &[Property], uses: &mut Uses) -> String {
    uses.recent.insert("TypedDict");
    let types: Vec<String> = properties.iter().map(|property| property_type(property, uses)).collect();
    let is_word = |key: &str| types.iter().any(|ty| words(ty).any(|word| word == key));
    // A name in a class hides that of a type from those below it.
    if properties.iter().all(|property| is_attribute(&property.key) && !is_word(&property.key)) {
        let members: Vec<String> = properties
            .iter()
            .zip(&types)
            .map(|(property, ty)| {
                format!("{INDENT}{}: {ty}\n{}", property.key, text::docstring(&property.text, INDENT))
            })
            .collect();
        return class(name, "(TypedDict)", said, &members);
    }
    let members: String = properties
        .iter()
        .zip(&types)
        .map(|(property, ty)| {
            let indent = "        ";
            format!("{}{indent}{}: {ty},\n", text::comment(&property.text, indent), quoted(&property.key))
        })
        .collect();
    format!(
        "{name} = TypedDict(\n    \"{name}\",\n    {{\n{members}    }},\n)\n{}",
        text::docstring(said, "")
    )
}

fn property_type(property: &Property, uses: &mut Uses) -> String {
    let ty = ty(&property.ty, uses);
    if property.is_required {
        return ty;
    }
    uses.recent.insert("NotRequired");
    format!("NotRequired[{ty}]")
}
