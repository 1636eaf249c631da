//! Declarations in each [`Language`] of generated files.

use uavspec_schema::value::Value;

use super::comment;
use super::language::Language;
use super::types::{any_other, is_exact, key, ty, type_of_value, value};
use crate::binding::{Declaration, Kind, Named, Property, Type};

/// Formats a declaration, or returns an empty string if files in `language` omit it.
pub(super) fn declaration(declaration: &Declaration, language: Language) -> String {
    let Declaration { name, text, kind } = declaration;
    let documentation = comment::block(text, "");
    match kind {
        Kind::Record { properties, is_closed } if language.has_types() => {
            documentation + &record(name, properties, *is_closed)
        }
        Kind::Alias(aliased) if language.has_types() => {
            format!("{documentation}export type {name} = {};\n", ty(aliased))
        }
        Kind::Messages(entries) if language.has_types() => documentation + &messages(name, entries),
        Kind::Record { .. } | Kind::Alias(_) | Kind::Messages(_) => String::new(),
        Kind::Constants(members) => constant(name, &documentation, members, language),
        Kind::Enumeration { is_flags, members, .. } => {
            let value = constant(name, &documentation, members, language);
            if !language.has_types() {
                return value;
            }
            let has_no_literals = *is_flags || !members.iter().any(has_literal);
            let literals = if has_no_literals { String::new() } else { literals(name, members) };
            let other = any_other("number", has_no_literals);
            format!("{value}\n{documentation}export type {name} = {literals}{other};\n")
        }
    }
}

/// An object of named values.
pub(super) fn constant(name: &str, documentation: &str, members: &[Named], language: Language) -> String {
    let members: String = members
        .iter()
        .map(|member| {
            let (key, documentation) = (key(&member.name), comment::block(&member.text, "  "));
            match language {
                Language::Declarations => {
                    format!("{documentation}  readonly {key}: {};\n", type_of_value(&member.value))
                }
                // Omit the documentation, which is only in the type declarations.
                Language::JavaScript | Language::CommonJs => format!("  {key}: {},\n", value(&member.value)),
                Language::TypeScript => format!("{documentation}  {key}: {},\n", value(&member.value)),
            }
        })
        .collect();
    match language {
        Language::TypeScript => format!("{documentation}export const {name} = {{\n{members}}} as const;\n"),
        Language::JavaScript => format!("export const {name} = {{\n{members}}};\n"),
        Language::CommonJs => format!("exports.{name} = {{\n{members}}};\n"),
        Language::Declarations => {
            format!("{documentation}export declare const {name}: {{\n{members}}};\n")
        }
    }
}

fn record(name: &str, properties: &[Property], is_closed: bool) -> String {
    if properties.is_empty() {
        // Use a type alias, because an empty interface would accept any value except null.
        let value = if is_closed { "never" } else { "unknown" };
        return format!("export type {name} = {{ [key: string]: {value} }};\n");
    }
    let properties: String = properties
        .iter()
        .map(|property| {
            let mark = if property.is_required { "" } else { "?" };
            let documentation = comment::block(&property.text, "  ");
            format!("{documentation}  {}{mark}: {};\n", key(&property.key), ty(&property.ty))
        })
        .collect();
    format!("export interface {name} {{\n{properties}}}\n")
}

fn messages(name: &str, entries: &[(String, Type)]) -> String {
    let entries: String =
        entries.iter().map(|(message, found)| format!("  {}: {};\n", key(message), ty(found))).collect();
    format!("export interface {name} {{\n{entries}}}\n")
}

/// The union of the members that a `number` can represent exactly.
fn literals(name: &str, members: &[Named]) -> String {
    if members.iter().all(has_literal) {
        return format!("(typeof {name})[keyof typeof {name}] | ");
    }
    let literals = members.iter().filter(|member| has_literal(member));
    literals.map(|member| format!("{} | ", value(&member.value))).collect()
}

fn has_literal(member: &Named) -> bool {
    matches!(member.value, Value::Int(value) if is_exact(value))
}
