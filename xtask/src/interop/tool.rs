//! The tools, as `xtask/interop/tools.toml` lists them.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Deserialize;

use super::job::Form;

/// A tool that takes JSON Schemas.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tool {
    /// The name that it is called by here.
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) language: String,
    /// The latest draft of JSON Schema that it knows.
    pub(super) draft: String,
    pub(super) environment: Environment,
    /// The adapter: a file of the environment's folder, or a package of the Rust workspace.
    pub(super) adapter: String,
    /// The only form of schemas that it can be given, where it can't be given both.
    pub(super) form: Option<Form>,
    /// Whether it is part of the quick run.
    #[serde(default)]
    pub(super) is_quick: bool,
    /// What it is set to, and what its adapter does with it.
    pub(super) note: String,
}

/// What a tool does with a schema.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    /// It tells valid instances from others.
    Validator,
    /// It makes code that reads valid instances.
    Generator,
}

/// What an adapter runs in.
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

/// Reads the table.
pub(super) fn read(path: &Path) -> Result<Vec<Tool>, String> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
    let Table { tool: tools } = toml::from_str(&text).map_err(|error| at(&error))?;
    let mut names = BTreeSet::new();
    match tools.iter().find(|tool| !names.insert(&tool.name)) {
        Some(tool) => Err(at(&format!("two tools are called `{}`", tool.name))),
        None => Ok(tools),
    }
}
