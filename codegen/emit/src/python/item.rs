//! Declarations in Python syntax.

use std::collections::HashSet;

use super::text;
use super::types::{is_attribute, ty, value, words};
use super::uses::Uses;
use crate::binding::{Declaration, Kind, Named, Property, quoted};

const INDENT: &str = "    ";

/// Formats a declaration.
pub(super) fn declaration(declaration: &Declaration, uses: &mut Uses) -> String {
    let Declaration { name, text: documentation, kind } = declaration;
    match kind {
        Kind::Record { properties, .. } => record(name, documentation, properties, uses),
        Kind::Alias(aliased) => {
            uses.recent.insert("TypeAlias");
            let aliased = ty(aliased, uses);
            format!("{name}: TypeAlias = {aliased}\n{}", text::docstring(documentation, ""))
        }
        Kind::Enumeration { is_flags, is_signed, members } => {
            // Don't use `IntFlag` for signed types. In Python, a negative `IntFlag` value is the complement of a set of
            // flags.
            let base = if *is_flags && !is_signed {
                uses.is_flags_used = true;
                "IntFlag"
            } else {
                uses.is_open_enum_used = true;
                "OpenIntEnum"
            };
            class(name, &format!("({base})"), documentation, &named(members, " = "))
        }
        Kind::Constants(members) => {
            uses.typing.insert("Final");
            class(name, "", documentation, &named(members, ": Final = "))
        }
        Kind::Messages(_) => String::new(),
    }
}

/// Formats a class with its docstring and members.
pub(super) fn class(name: &str, bases: &str, documentation: &str, members: &[String]) -> String {
    let body: String = members.iter().map(|member| format!("\n{member}")).collect();
    let docstring = text::docstring(documentation, INDENT);
    let empty = if body.is_empty() && docstring.is_empty() { "    pass\n" } else { "" };
    format!("class {name}{bases}:\n{docstring}{body}{empty}")
}

/// Formats named values with their docstrings.
pub(super) fn named(members: &[Named], separator: &str) -> Vec<String> {
    let member = |member: &Named| {
        let docstring = text::docstring(&member.text, INDENT);
        format!("{INDENT}{}{separator}{}\n{docstring}", member.name, value(&member.value))
    };
    members.iter().map(member).collect()
}

fn record(name: &str, documentation: &str, properties: &[Property], uses: &mut Uses) -> String {
    uses.recent.insert("TypedDict");
    let types: Vec<String> = properties.iter().map(|property| property_type(property, uses)).collect();
    let type_names: HashSet<&str> = types.iter().map(String::as_str).flat_map(words).collect();
    // Use the class syntax only if no attribute name would shadow the name of a type in the class body.
    if properties.iter().all(|property| is_attribute(&property.key) && !type_names.contains(&*property.key)) {
        let members: Vec<String> = properties
            .iter()
            .zip(&types)
            .map(|(property, ty)| {
                format!("{INDENT}{}: {ty}\n{}", property.key, text::docstring(&property.text, INDENT))
            })
            .collect();
        return class(name, "(TypedDict)", documentation, &members);
    }
    let members = properties.iter().zip(&types);
    let members: String =
        members.map(|(property, ty)| format!("        {}: {ty},\n", quoted(&property.key))).collect();
    let documentation = [documentation.to_owned(), fields(properties)].join("\n\n");
    format!(
        "{name} = TypedDict(\n    \"{name}\",\n    {{\n{members}    }},\n)\n{}",
        text::docstring(documentation.trim(), "")
    )
}

/// A list of the fields, because the arguments of a call have no docstrings.
fn fields(properties: &[Property]) -> String {
    let documented = properties.iter().filter(|property| !property.text.is_empty());
    let items = documented.map(|property| {
        let lines = property.text.lines().filter(|line| !line.is_empty());
        format!("- {}: {}", property.key, lines.collect::<Vec<_>>().join("\n  "))
    });
    items.collect::<Vec<_>>().join("\n")
}

fn property_type(property: &Property, uses: &mut Uses) -> String {
    let ty = ty(&property.ty, uses);
    if property.is_required {
        return ty;
    }
    uses.recent.insert("NotRequired");
    format!("NotRequired[{ty}]")
}
