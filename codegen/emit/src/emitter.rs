//! The emitter interface that the configuration and the command line use.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fmt, iter};

use schemars::{JsonSchema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use uavspec_dynamic::conversion::Conversions;
use uavspec_lint::release::Releases;
use uavspec_schema::Schema;
use uavspec_schema::failure::Failure;
use uavspec_schema::path::seen_from;
use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::Translations;

use super::file::OutputFile;

/// A kind of output: one row of [`EMITTERS`](super::EMITTERS).
#[derive(Clone, Copy)]
pub struct Emitter {
    /// Name: a key of the `output` table and a value of `--emit`.
    pub name: &'static str,
    /// A short description.
    pub help: &'static str,
    schema: fn(&mut SchemaGenerator) -> schemars::Schema,
    default: fn() -> Box<dyn Output>,
    read: fn(toml::Table) -> Result<Box<dyn Output>, toml::de::Error>,
}

/// The input of all emitters.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The resolved schema.
    pub schema: &'a Schema,
    /// Translations of the texts in the schema.
    pub translations: &'a Translations,
    /// Source texts of the definitions.
    pub sources: &'a SourceMap,
    /// The conversions between packages.
    pub conversions: &'a [Conversions],
    /// The releases of the packages.
    pub releases: &'a Releases,
}

/// Options of one emitter.
pub trait Output: fmt::Debug + Send + Sync {
    /// Fills in defaults that depend on the other outputs of the configuration.
    fn complete(&mut self, _others: &Others<'_>) {}

    /// Emits all files.
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure>;
}

/// One entry of the `output` table in the configuration.
#[derive(Clone, Debug)]
pub struct Table {
    /// Output folder, relative to the folder of the configuration file.
    pub path: PathBuf,
    /// All other keys.
    pub options: toml::Table,
}

/// All outputs of a configuration, as seen by one emitter.
pub struct Others<'a> {
    /// Folder of the configuration file.
    pub folder: &'a Path,
    /// Output folder of this emitter.
    pub path: &'a Path,
    /// Output tables by emitter name.
    pub tables: &'a BTreeMap<&'static str, Table>,
}

impl Emitter {
    /// Creates a row whose options have the type `O`.
    pub(super) const fn new<O: Output + Default + DeserializeOwned + JsonSchema + 'static>(
        name: &'static str,
        help: &'static str,
    ) -> Self {
        let read = |table| -> Result<Box<dyn Output>, _> { Ok(Box::new(O::deserialize(table)?)) };
        Self { name, help, schema: O::json_schema, default: || Box::new(O::default()), read }
    }

    /// The JSON Schema for a value in the `output` table: a path, or a table with a path and options.
    pub fn schema(&self, generator: &mut SchemaGenerator) -> schemars::Schema {
        let options = (self.schema)(generator);
        let mut properties = Map::new();
        properties.insert("path".to_owned(), json!({ "description": "Output folder.", "type": "string" }));
        properties.extend(options.get("properties").and_then(Value::as_object).cloned().unwrap_or_default());
        schemars::json_schema!({
            "description": format!("{}.", self.help),
            "anyOf": [
                { "type": "string" },
                { "type": "object", "properties": properties, "required": ["path"], "additionalProperties": false },
            ],
        })
    }

    /// The keys of the options, with their meanings.
    pub fn options(&self) -> Vec<(String, String)> {
        let schema = (self.schema)(&mut SchemaGenerator::default());
        let properties = schema.get("properties").and_then(Value::as_object);
        let meaning = |option: &Value| option["description"].as_str().unwrap_or_default().replace('\n', " ");
        properties.into_iter().flatten().map(|(key, option)| (key.clone(), meaning(option))).collect()
    }

    /// The output with default options.
    pub fn default(&self) -> Box<dyn Output> {
        (self.default)()
    }

    /// Reads the options from their table.
    pub fn read(&self, options: toml::Table) -> Result<Box<dyn Output>, String> {
        (self.read)(options).map_err(|error| error.message().to_owned())
    }

    /// Reads a value in the `output` table: a path, or a table with a path and options.
    pub fn table(&self, value: toml::Value) -> Result<Table, String> {
        let (path, options) = match value {
            toml::Value::Table(mut options) => (options.remove("path"), options),
            value => (Some(value), toml::Table::new()),
        };
        match path {
            Some(toml::Value::String(path)) => Ok(Table { path: path.into(), options }),
            _ => Err(format!("expected a path, or a table with the keys {}", self.keys())),
        }
    }

    /// Lists the keys of the output table.
    fn keys(&self) -> String {
        let options = self.options().into_iter().map(|(key, _)| key);
        let keys = iter::once("path".to_owned()).chain(options).map(|key| format!("`{key}`"));
        keys.collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Debug for Emitter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name)
    }
}

impl Others<'_> {
    /// Resolves a path relative to the folder of the configuration file.
    pub(crate) fn place(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// The URL of another output's folder, relative to the folder of this output.
    pub(crate) fn address(&self, name: &str) -> Option<String> {
        Some(seen_from(self.path, &self.tables.get(name)?.path))
    }

    /// A string option of another output.
    pub(crate) fn text(&self, name: &str, key: &str) -> Option<&str> {
        self.tables.get(name)?.options.get(key)?.as_str()
    }
}
