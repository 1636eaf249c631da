//! The list of tools in `xtask/interop/tools.toml`.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;

use super::job::Form;

/// A tool that supports JSON Schema.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tool {
    /// The name.
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) language: String,
    /// The latest supported draft of JSON Schema.
    pub(super) draft: String,
    pub(super) environment: Environment,
    /// The adapter: a file in the environment's folder, or a package of the Rust workspace.
    pub(super) adapter: String,
    /// The supported form of schemas; `None` if the tool supports both forms.
    pub(super) form: Option<Form>,
    /// True if the tool is part of the quick run.
    #[serde(default)]
    pub(super) is_quick: bool,
    /// A description of the tool's settings and of its adapter.
    pub(super) note: String,
}

/// The kind of a tool.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    /// Checks instances.
    Validator,
    /// Generates code that reads valid instances.
    Generator,
}

/// The environment of an adapter.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
pub(super) enum Environment {
    Node,
    Python,
    Rust,
    Cpp,
    Perl,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    tool: Vec<Tool>,
}

/// Reads the list.
pub(super) fn read(path: &Path) -> Result<Vec<Tool>, String> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
    let Table { tool: tools } = toml::from_str(&text).map_err(|error| at(&error))?;
    let mut names = BTreeSet::new();
    match tools.iter().find(|tool| !names.insert(&tool.name)) {
        Some(tool) => Err(at(&format!("duplicate tool `{}`", tool.name))),
        None => Ok(tools),
    }
}
