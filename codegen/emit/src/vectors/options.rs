//! Options of the emitter.

use crate::json_schema;

/// Options of the emitter.
#[derive(Clone, Debug, Default, PartialEq, Eq, schemars::JsonSchema, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// URL prefix of every `$id`. Default: `output.json_schema.base`.
    pub base: Option<String>,
}

impl Options {
    /// Options of the schemas that the vectors refer to.
    pub(super) fn schemas(&self) -> json_schema::Options {
        self.base.clone().map_or_else(json_schema::Options::default, |base| json_schema::Options { base })
    }
}
