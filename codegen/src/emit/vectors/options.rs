//! Options of the emitter.

use crate::emit::json_schema;

/// How vectors are emitted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Options {
    /// The absolute address that every `$id` of the schemas starts with, if it isn't the default.
    pub base: Option<String>,
}

impl Options {
    /// How the schemas are emitted that the vectors refer to.
    pub(super) fn schemas(&self) -> json_schema::Options {
        self.base.clone().map_or_else(json_schema::Options::default, |base| json_schema::Options { base })
    }
}
