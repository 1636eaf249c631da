//! Stand-ins for user-supplied JSON Schemas, for programs without the feature `schemas`.

use std::fmt;
use std::path::PathBuf;

use uavspec_model::json::Tree;
use uavspec_model::text::terminal;
use uavspec_schema::json_type::Direction;

use super::{DefinedSchemas, Deviation};

/// No schemas, since this program can't read user-supplied JSON Schemas.
#[derive(Debug, Default)]
pub struct Schemas(());

/// The reason why user-supplied schemas can't be used.
#[derive(Debug)]
pub struct SchemaError {
    /// The folder.
    path: PathBuf,
}

impl fmt::Display for SchemaError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problem = "this program can't read JSON Schemas: build it with `--features schemas`";
        write!(formatter, "{}: {problem}", terminal::path(&self.path))
    }
}

impl std::error::Error for SchemaError {}

#[allow(clippy::unused_self, reason = "as in a program with schemas")]
impl Schemas {
    /// Fails if a folder is given.
    pub fn load(folders: &[PathBuf], _: &DefinedSchemas) -> Result<Self, SchemaError> {
        match folders.first() {
            Some(folder) => Err(SchemaError { path: folder.clone() }),
            None => Ok(Self(())),
        }
    }

    pub(crate) fn has(&self, _: &str) -> bool {
        false
    }

    pub(crate) fn is_defined(&self, _: &str, _: Direction) -> bool {
        false
    }

    pub(crate) fn check(&self, _: &str, _: Direction, _: &Tree<'_>) -> Option<Vec<Deviation>> {
        None
    }
}
