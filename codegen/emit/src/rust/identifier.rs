//! Conversion of definition names to Rust identifiers.

use proc_macro2::{Ident, Span};
use uavspec_schema::name::is_reserved;

pub(super) use crate::identifier::{Scope, pascal_case, snake_case, type_name, upper_case};

/// Keywords of edition 2024 that are valid as raw identifiers.
const KEYWORDS: [&str; 49] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "do", "dyn", "else",
    "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro",
    "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "static", "struct", "trait",
    "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
    "static",
];

/// Words that are invalid even as raw identifiers.
const NEVER: [&str; 5] = ["self", "Self", "super", "crate", "_"];

/// Creates an identifier from `name`, which already has the right case.
pub(super) fn ident(name: &str) -> Ident {
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if NEVER.contains(&name.as_str()) {
        return Ident::new(&format!("{name}_"), Span::call_site());
    }
    if KEYWORDS.contains(&name.as_str()) {
        return Ident::new_raw(&name, Span::call_site());
    }
    if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() {
        return Ident::new(&format!("_{name}"), Span::call_site());
    }
    Ident::new(&name, Span::call_site())
}

/// The name of a module and its file. `mod.rs` would be a second file for the parent module, and Windows reserves names
/// such as `aux.rs`.
pub(super) fn module_name(name: &str) -> String {
    let name = snake_case(name);
    if NEVER.contains(&name.as_str()) || name == "mod" || is_reserved(&name) { name + "_" } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_keywords() {
        for (name, expected) in
            [("type", "r#type"), ("self", "self_"), ("gen", "r#gen"), ("3D", "_3D"), ("x", "x")]
        {
            assert_eq!(ident(name).to_string(), expected);
        }
    }
}
