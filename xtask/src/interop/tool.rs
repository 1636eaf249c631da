//! The list of tools in `xtask/interop/tools.toml`.

use serde::Deserialize;

use super::job::Form;

/// The content of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tools {
    pub(super) tool: Vec<Tool>,
}

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
    /// The environment of the adapter, as in `environment.sh`.
    pub(super) environment: String,
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
