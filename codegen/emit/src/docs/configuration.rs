//! Options of the `output.docs` table in the configuration.

use std::fs;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use uavspec_schema::failure::Failure;
use uavspec_schema::terminal;

use super::options::{Options, Siblings};
use super::pages::emit;
use crate::emitter::{Input, Others, Output};
use crate::file::OutputFile;

/// The options as configured.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Configuration {
    /// The title of the book.
    title: Option<String>,
    /// `true` to include the pages about the rules of lint and breaking.
    rules: bool,
    /// One or more mdBook tables of contents, whose entries are added to the table of contents.
    contents: OneOrMany,
    #[serde(skip)]
    siblings: Siblings,
}

/// A path or a list of paths.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a path, or a list of paths")]
enum OneOrMany {
    One(PathBuf),
    Many(Vec<PathBuf>),
}

impl Default for OneOrMany {
    fn default() -> Self {
        Self::Many(Vec::new())
    }
}

impl OneOrMany {
    fn paths(&self) -> &[PathBuf] {
        match self {
            Self::One(path) => std::slice::from_ref(path),
            Self::Many(paths) => paths,
        }
    }
}

impl Output for Configuration {
    fn complete(&mut self, others: &Others<'_>) {
        self.contents =
            OneOrMany::Many(self.contents.paths().iter().map(|path| others.place(path)).collect());
        self.siblings =
            Siblings { schemas: others.address("json_schema"), vectors: others.address("vectors") };
    }

    /// Reads the `contents` files only here, because other commands don't need them.
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        let read = |path: &PathBuf| {
            fs::read_to_string(path).map_err(|error| {
                Failure::new(format!("{}: {error}", terminal::path(path)))
                    .with_hint("create the file, or remove it from `output.docs.contents`")
            })
        };
        let default = Options::default();
        let options = Options {
            title: self.title.clone().unwrap_or(default.title),
            rules: self.rules,
            more_contents: self.contents.paths().iter().map(read).collect::<Result<String, Failure>>()?,
            siblings: self.siblings.clone(),
            releases: input.releases.clone(),
        };
        Ok(emit(input.schema, input.translations, input.sources, &options))
    }
}
