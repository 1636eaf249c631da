//! Emitters as the configuration and the command line know them.

use std::collections::BTreeMap;
use std::fmt;
use std::iter;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::file::OutputFile;
use crate::failure::Failure;
use crate::path::seen_from;
use crate::schema::Schema;
use crate::source::SourceMap;
use crate::translation::Translations;

/// A kind of output: a row of [`EMITTERS`](super::EMITTERS).
#[derive(Clone, Copy)]
pub struct Emitter {
    /// Its name: a key of the table `output`, and a value of `--emit`.
    pub name: &'static str,
    /// A short description.
    pub help: &'static str,
    /// The keys of its options, each with its meaning.
    pub options: &'static [(&'static str, &'static str)],
    default: fn() -> Box<dyn Output>,
    read: fn(toml::Table) -> Result<Box<dyn Output>, toml::de::Error>,
}

/// The definitions that emitters work from.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The resolved model.
    pub schema: &'a Schema,
    /// Its translations.
    pub translations: &'a Translations,
    /// The texts of the definitions.
    pub sources: &'a SourceMap,
}

/// The options of an emitter, ready to emit.
pub(crate) trait Output: fmt::Debug + Send + Sync {
    /// Takes over what the other outputs of the configuration say.
    fn complete(&mut self, _others: &Others<'_>) {}

    /// Emits all files.
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure>;
}

/// The table of an output in the configuration.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    /// The folder of the output, relative to that of the configuration.
    pub(crate) path: PathBuf,
    /// All other keys.
    pub(crate) options: toml::Table,
}

/// All outputs of a configuration, as one of them sees them.
pub(crate) struct Others<'a> {
    /// The folder of the configuration.
    pub(crate) folder: &'a Path,
    /// The folder of the output that looks at the others.
    pub(crate) path: &'a Path,
    /// The tables by the names of their emitters.
    pub(crate) tables: &'a BTreeMap<&'static str, Table>,
}

impl Emitter {
    /// A row with the options `O`.
    pub(super) const fn new<O: Output + Default + DeserializeOwned + 'static>(
        name: &'static str,
        help: &'static str,
        options: &'static [(&'static str, &'static str)],
    ) -> Self {
        let read = |table| -> Result<Box<dyn Output>, _> { Ok(Box::new(O::deserialize(table)?)) };
        Self { name, help, options, default: || Box::new(O::default()), read }
    }

    /// The output without options.
    pub(crate) fn default(&self) -> Box<dyn Output> {
        (self.default)()
    }

    /// Reads options; else says what is wrong with them.
    pub(crate) fn read(&self, options: toml::Table) -> Result<Box<dyn Output>, String> {
        (self.read)(options).map_err(|error| error.message().to_owned())
    }

    /// Splits the value of a key of `output`, a path or a table; else says what it should be.
    pub(crate) fn table(&self, value: toml::Value) -> Result<Table, String> {
        let (path, options) = match value {
            toml::Value::Table(mut options) => (options.remove("path"), options),
            value => (Some(value), toml::Table::new()),
        };
        match path {
            Some(toml::Value::String(path)) => Ok(Table { path: path.into(), options }),
            _ => Err(format!("expected a path, or a table of {}", self.keys())),
        }
    }

    /// The keys of its table.
    fn keys(&self) -> String {
        let options = self.options.iter().map(|(key, _)| *key);
        let keys: Vec<String> = iter::once("path").chain(options).map(|key| format!("`{key}`")).collect();
        keys.join(", ")
    }
}

impl fmt::Debug for Emitter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name)
    }
}

impl Others<'_> {
    /// The place of a file that the configuration names.
    pub(crate) fn place(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// The folder of another output as an address in a page of this one.
    pub(crate) fn address(&self, name: &str) -> Option<String> {
        Some(seen_from(self.path, &self.tables.get(name)?.path))
    }

    /// A text among the options of another output.
    pub(crate) fn text(&self, name: &str, key: &str) -> Option<&str> {
        self.tables.get(name)?.options.get(key)?.as_str()
    }
}

/// Options of an emitter that the build doesn't have.
#[cfg(not(feature = "rust"))]
#[derive(Debug, Default, serde::Deserialize)]
pub(super) struct Absent {}

#[cfg(not(feature = "rust"))]
impl Output for Absent {
    fn emit(&self, _: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        let failure = Failure::new("this build can't emit Rust");
        Err(failure.with_hint("enable the feature `rust` of uavspec-codegen"))
    }
}
