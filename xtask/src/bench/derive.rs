//! Writes plain structs with derives for all PX4 messages, to compare them with the generated code.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const MANIFEST: &str = r#"[package]
name = "px4-derive"
version = "0.0.0"
edition = "2024"

[features]
defmt = ["dep:defmt"]
proptest = ["dep:proptest", "dep:proptest-derive"]
schemars = ["dep:schemars"]
serde = ["dep:serde"]
views = []

[dependencies]
defmt = { version = "1", features = ["alloc"], optional = true }
proptest = { version = "1", default-features = false, features = ["std"], optional = true }
proptest-derive = { version = "0.8", optional = true }
schemars = { version = "1", optional = true }
serde = { version = "1", features = ["derive"], optional = true }

[workspace]
"#;

const DERIVES: &str = r#"#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "proptest", derive(proptest_derive::Arbitrary))]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
"#;

/// Writes a crate to `folder`. The crate contains the structs from the generated modules in the folder `messages`.
pub(super) fn write(messages: &Path, folder: &Path) -> Result<(), String> {
    let at = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut text = String::from("#![allow(ambiguous_glob_reexports)]\npub mod px4 {\n");
    for entry in fs::read_dir(messages).map_err(at)? {
        let path = entry.map_err(at)?.path();
        let module = path.file_stem().map(|name| name.to_string_lossy()).unwrap_or_default();
        let structs = structs(&fs::read_to_string(&path).map_err(at)?);
        let _ = write!(text, "pub use self::{module}::*;\npub mod {module} {{\n{structs}}}\n");
    }
    text.push_str("}\n");
    fs::create_dir_all(folder.join("src")).map_err(at)?;
    fs::write(folder.join("Cargo.toml"), MANIFEST).map_err(at)?;
    fs::write(folder.join("src/lib.rs"), text).map_err(at)
}

/// The structs of a generated module, without items that the derives don't support.
fn structs(module: &str) -> String {
    let mut text = String::new();
    let mut is_struct = false;
    for line in module.lines() {
        if line.starts_with("pub struct ") {
            is_struct = line.ends_with('{');
            let _ = writeln!(text, "{DERIVES}{line}");
        } else if is_struct && line.starts_with("    pub ") {
            let _ = writeln!(text, "{}", plain(line));
        } else if is_struct && line == "}" {
            text.push_str("}\n");
            is_struct = false;
        }
    }
    text
}

/// A field. Arrays of more than 32 elements become vectors, because serde doesn't support such arrays.
fn plain(field: &str) -> String {
    let Some((name, ty)) = field.split_once(": ") else { return field.to_owned() };
    let ty = ty.trim_end_matches(',');
    if ty.contains("Text<") {
        return format!("{name}: Vec<u8>,");
    }
    let array = ty.strip_prefix('[').and_then(|ty| ty.strip_suffix(']')?.split_once("; "));
    match array {
        Some((element, length)) if length.parse::<u32>().is_ok_and(|length| length > 32) => {
            format!("{name}: Vec<{element}>,")
        }
        _ => format!("{name}: {ty},"),
    }
}
