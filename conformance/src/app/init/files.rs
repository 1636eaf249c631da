//! The files that `uavspec init` writes.

use std::fmt::Write as _;
use std::path::Path;

use toml::Value;
use uavspec_codegen::load::FoundPackage;
use uavspec_runtime::sources::{Dir, LICENCES, SOURCES};

use crate::app::new_files::NewFiles;

/// The folder for the copy of the crate `uavspec-runtime`.
pub(super) const RUNTIME: &str = "uavspec-runtime";

const COMMANDS: &str = "# Definitions and outputs of uavspec. Paths are relative to this folder.
#
#   uavspec codegen    generates the outputs
#   uavspec lint       checks the definitions
#   uavspec fmt        formats the definitions
";

/// The root of the crate for the generated code. It exists before the code is generated, because Cargo needs it to run
/// the generator.
const MESSAGES: &str = "//! The messages in `uavspec.toml`.

mod generated;

pub use generated::*;
";

impl NewFiles {
    /// Adds a definition.
    pub(super) fn add_example(&mut self) {
        self.add("msg/Wind.msg", include_str!("Wind.msg"));
    }

    /// Adds `uavspec.toml`.
    pub(super) fn add_configuration(&mut self, outputs: &[&str], packages: &[FoundPackage]) {
        let mut text = format!("{COMMANDS}\n[output]\n{}\n", outputs.join("\n"));
        for FoundPackage { name, dialect, include } in packages {
            let patterns: Vec<String> =
                include.iter().map(|pattern| Value::from(pattern.as_str()).to_string()).collect();
            // Writing to a string can't fail.
            let _ = write!(
                text,
                "\n[[package]]\nname = \"{name}\"\ndialect = \"{}\"\ninclude = [{}]\n",
                dialect.name(),
                patterns.join(", ")
            );
        }
        self.add("uavspec.toml", text);
    }

    /// Adds a Cargo workspace with two crates: one for the generated code, and one that the generated code depends on.
    pub(super) fn add_crate(&mut self) {
        self.new_folder = Some(RUNTIME);
        self.add("Cargo.toml", include_str!("workspace.toml"));
        self.add("messages/Cargo.toml", include_str!("messages.toml"));
        self.add("messages/src/lib.rs", MESSAGES);
        let manifest = include_str!("runtime.toml").replace("VERSION", env!("CARGO_PKG_VERSION"));
        self.add(format!("{RUNTIME}/Cargo.toml"), manifest);
        for (name, text) in LICENCES {
            self.add(format!("{RUNTIME}/{name}"), text);
        }
        self.add_folder(&SOURCES);
    }

    fn add_folder(&mut self, folder: &Dir<'_>) {
        for file in folder.files() {
            let path = Path::new(RUNTIME).join("src").join(file.path());
            self.add(path, file.contents());
        }
        for folder in folder.dirs() {
            self.add_folder(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use toml::Table;

    use super::*;

    fn manifest(path: &str) -> Table {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
        fs::read_to_string(path).expect("a manifest").parse().expect("TOML")
    }

    /// Resolves `workspace = true` to the value in the workspace.
    fn resolved(value: &Value, shared: &Value) -> Value {
        let Some(members) = value.as_table().filter(|members| members.contains_key("workspace")) else {
            return value.clone();
        };
        let Some(shared) = shared.as_table() else { return shared.clone() };
        let own = members.iter().filter(|(key, _)| *key != "workspace");
        Value::Table(shared.iter().chain(own).map(|(key, value)| (key.clone(), value.clone())).collect())
    }

    #[test]
    fn the_manifest_of_the_copy_is_that_of_the_crate() {
        let mut files = NewFiles::default();
        files.add_crate();
        let copied = files.files.iter().find(|(path, _)| path.ends_with("uavspec-runtime/Cargo.toml"));
        let copied = std::str::from_utf8(&copied.expect("a manifest").1).expect("UTF-8");
        let copied: Table = copied.parse().expect("TOML");
        let (own, root) = (manifest("generated/runtime/Cargo.toml"), manifest("Cargo.toml"));
        // The weak features in `alloc` would make Cargo look for optional dependencies in a registry.
        let mut features = own["features"].as_table().expect("features").clone();
        let weak = features.insert("alloc".to_owned(), Value::Array(Vec::new()));
        let weak = weak.expect("a feature").to_string();
        assert_eq!(copied["features"], Value::Table(features));
        let expected = own["dependencies"].as_table().expect("dependencies").iter().map(|(name, value)| {
            let shared = match &root["workspace"]["dependencies"][name] {
                Value::String(version) => {
                    Table::from_iter([("version".to_owned(), version.as_str().into())]).into()
                }
                table => table.clone(),
            };
            let mut resolved = resolved(value, &shared);
            if weak.contains(&format!("\"{name}?/alloc\"")) {
                let members = resolved.as_table_mut().expect("members");
                members.insert("features".to_owned(), ["alloc"].map(Value::from).to_vec().into());
            }
            (name.clone(), resolved)
        });
        assert_eq!(copied["dependencies"], Value::Table(expected.collect()));
        for key in ["name", "version", "edition", "rust-version", "license"] {
            let own = &own["package"][key];
            let shared = root["workspace"]["package"].get(key).unwrap_or(own);
            assert_eq!(copied["package"][key], resolved(own, shared), "{key}");
        }
    }

    #[test]
    fn the_copy_contains_all_source_files() {
        let mut files = NewFiles::default();
        files.add_crate();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated/runtime/src");
        let mut expected: Vec<(PathBuf, Vec<u8>)> = walkdir::WalkDir::new(&folder)
            .into_iter()
            .map(|entry| entry.expect("an entry"))
            .filter(|entry| entry.file_type().is_file())
            .map(|entry| {
                let path =
                    Path::new("uavspec-runtime/src").join(entry.path().strip_prefix(&folder).expect("below"));
                (path, fs::read(entry.path()).expect("a file"))
            })
            .collect();
        expected.sort();
        let mut copied: Vec<_> =
            files.files.into_iter().filter(|(path, _)| path.starts_with("uavspec-runtime/src")).collect();
        copied.sort();
        assert!(copied == expected, "the files differ");
    }
}
