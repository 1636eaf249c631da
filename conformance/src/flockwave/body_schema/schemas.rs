//! User-supplied JSON Schemas for message types without a definition.

mod expansion;

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jsonschema::{Retrieve, Uri, Validator};
use serde_json::Value;
use uavspec_codegen::schema::json_type::Direction;
use walkdir::WalkDir;

use self::expansion::{Anchors, MAX_SCHEMAS};
use super::{Deviation, Mismatch};
use crate::json::Tree;
use crate::text::{shown, terminal};

/// The maximum size of a file, in bytes.
const MAX_BYTES: u64 = 16 << 20;

/// The maximum number of deviations to report for a body.
const MAX_DEVIATIONS: usize = 100;

/// The maximum length of a quoted part of a schema, in characters.
const MAX_DEMAND: usize = 80;

/// The base address of files without `$id`. Files without `$id` refer to each other by names relative to this address.
const BASE: &str = "uavspec://schemas/";

/// JSON Schemas for bodies, by message type.
#[derive(Debug, Default)]
pub struct Schemas {
    by_type: HashMap<String, Vec<Schema>>,
}

/// The schema in a file.
#[derive(Debug)]
struct Schema {
    file: PathBuf,
    /// The direction to which the schema applies; `None` means all directions.
    direction: Option<Direction>,
    value: Value,
    validator: Validator,
}

/// The reason why user-supplied schemas can't be used.
#[derive(Debug)]
pub struct SchemaError {
    /// The file or folder.
    path: PathBuf,
    /// The location in the file, as a line and column or as a JSON pointer; may be empty.
    location: String,
    /// The problem, and how to fix it.
    problem: String,
}

impl fmt::Display for SchemaError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let location = if self.location.is_empty() { String::new() } else { format!(":{}", self.location) };
        write!(formatter, "{}{location}: {}", terminal::path(&self.path), self.problem)
    }
}

impl std::error::Error for SchemaError {}

impl Schemas {
    /// Loads all `*.json` files in these folders and their subfolders. Schemas may refer to other files, but nothing is
    /// downloaded.
    pub fn load(folders: &[PathBuf]) -> Result<Self, SchemaError> {
        let mut schemas = Self::default();
        for (number, folder) in folders.iter().enumerate() {
            let files = Arc::new(Files::read(folder, number)?);
            let mut is_any = false;
            for (address, (path, value)) in &files.by_address {
                let types = types_of(path, value);
                if types.is_empty() {
                    continue;
                }
                is_any = true;
                let count = files.count(address, value).map_err(|problem| SchemaError {
                    path: path.clone(),
                    location: String::new(),
                    problem,
                })?;
                if count > MAX_SCHEMAS {
                    return Err(SchemaError {
                        path: path.clone(),
                        location: String::new(),
                        problem: format!(
                            "too many references: expanded, they yield more than {MAX_SCHEMAS} schemas"
                        ),
                    });
                }
                let build = || {
                    let options = jsonschema::options().with_base_uri(address.clone());
                    options.with_retriever(Lookup(Arc::clone(&files))).build(value)
                };
                for type_name in types {
                    let validator = build().map_err(|error| SchemaError {
                        path: path.clone(),
                        location: error.instance_path().to_string(),
                        problem: format!("invalid JSON Schema: {error}"),
                    })?;
                    let direction = direction_of(path);
                    let schema = Schema { file: path.clone(), direction, value: value.clone(), validator };
                    schemas.add(&type_name, schema)?;
                }
            }
            if !is_any {
                let problem = "no `*.json` file in this folder is a message schema: add a `const` or an `enum` to the \
                            `properties.type` of a schema, or name the file after the type, e.g. `SYS-VER.json`";
                return Err(SchemaError {
                    path: folder.clone(),
                    location: String::new(),
                    problem: problem.to_owned(),
                });
            }
        }
        Ok(schemas)
    }

    fn add(&mut self, type_name: &str, schema: Schema) -> Result<(), SchemaError> {
        let known = self.by_type.entry(type_name.to_owned()).or_default();
        if let Some(other) = known.iter().find(|other| other.direction == schema.direction) {
            let direction = schema.direction.map_or(String::new(), |direction| format!(" of a {direction}"));
            let problem = format!(
                "{} is also a schema for the body{direction} of {type_name}: remove one of the files, or add the \
                 direction to their names",
                terminal::path(&other.file)
            );
            return Err(SchemaError { path: schema.file, location: String::new(), problem });
        }
        known.push(schema);
        Ok(())
    }

    /// True if there is a schema for messages of this type.
    pub(crate) fn has(&self, type_name: &str) -> bool {
        self.by_type.contains_key(type_name)
    }

    /// True if there is a schema for messages of this type in this direction.
    pub(crate) fn is_defined(&self, type_name: &str, direction: Direction) -> bool {
        self.schema(type_name, direction).is_some()
    }

    /// The schema for a type and direction. A schema for this direction precedes one for all directions.
    fn schema(&self, type_name: &str, direction: Direction) -> Option<&Schema> {
        let schemas = self.by_type.get(type_name)?;
        let for_direction = |wanted| schemas.iter().find(|schema| schema.direction == wanted);
        for_direction(Some(direction)).or_else(|| for_direction(None))
    }

    /// The deviations of a body from its schema. `None` if there is no schema, or if the body contains values that JSON
    /// Schema can't express. Other rules report such values.
    pub(crate) fn check(
        &self,
        type_name: &str,
        direction: Direction,
        body: &Tree<'_>,
    ) -> Option<Vec<Deviation>> {
        let schema = self.schema(type_name, direction)?;
        let body = value_of(body)?;
        let errors = schema.validator.iter_errors(&body).take(MAX_DEVIATIONS);
        Some(errors.map(|error| schema.deviation(&error)).collect())
    }
}

impl Schema {
    fn deviation(&self, error: &jsonschema::ValidationError<'_>) -> Deviation {
        let at = error.schema_path().to_string();
        let demand = self.value.pointer(&at).map(|demand| {
            let text = demand.to_string();
            let short: String = text.chars().take(MAX_DEMAND).collect();
            let more = if short.len() < text.len() { "…" } else { "" };
            format!(": {short}{more}")
        });
        let expected = format!(
            "a value that matches {} at {at}{}",
            terminal::path(&self.file),
            demand.unwrap_or_default()
        );
        let text = error.instance().to_string();
        let actual = Tree::read(&text).map_or_else(|_| "another value".to_owned(), |found| found.to_string());
        let path = format!("/body{}", error.instance_path());
        let mismatch = Mismatch { path, expected, actual };
        Deviation {
            steps: Vec::new(),
            is_optional: false,
            fault: None,
            field: String::new(),
            definition: None,
            mismatch,
        }
    }
}

/// The files in a folder.
#[derive(Debug)]
struct Files {
    /// The files by address. A file's address is derived from its path in the folder.
    by_address: BTreeMap<String, (PathBuf, Value)>,
    /// The addresses by `$id`.
    by_id: HashMap<String, String>,
    /// The addresses of files that contain references and a schema with its own `$id`, with that `$id`. It changes the
    /// meaning of references.
    embedding: HashMap<String, String>,
}

impl Files {
    fn read(folder: &Path, number: usize) -> Result<Self, SchemaError> {
        let mut files =
            Self { by_address: BTreeMap::new(), by_id: HashMap::new(), embedding: HashMap::new() };
        let at = |path: &Path, problem: String| SchemaError {
            path: path.to_owned(),
            location: String::new(),
            problem,
        };
        for entry in WalkDir::new(folder).sort_by_file_name() {
            let entry = entry.map_err(|error| {
                let path = error.path().unwrap_or(folder).to_owned();
                let error = error
                    .io_error()
                    .map_or_else(|| "a symbolic link forms a loop".to_owned(), ToString::to_string);
                at(&path, format!("can't be read: {error}"))
            })?;
            let path = entry.path();
            if !entry.file_type().is_file() || path.extension().is_none_or(|extension| extension != "json") {
                continue;
            }
            let mut text = String::new();
            File::open(path)
                .and_then(|file| file.take(MAX_BYTES + 1).read_to_string(&mut text))
                .map_err(|error| at(path, format!("can't be read: {error}")))?;
            if text.len() as u64 > MAX_BYTES {
                return Err(at(path, format!("larger than {MAX_BYTES} bytes")));
            }
            let value: Value = serde_json::from_str(&text).map_err(|error| SchemaError {
                path: path.to_owned(),
                location: format!("{}:{}", error.line(), error.column()),
                problem: format!("invalid JSON: {error}"),
            })?;
            let below = path.strip_prefix(folder).unwrap_or(path);
            let address = format!("{BASE}{number}/{}", address(below));
            if let Some(id) = value["$id"].as_str() {
                files.by_id.entry(id.trim_end_matches('#').to_owned()).or_insert_with(|| address.clone());
            }
            if let Some(id) = expansion::ambiguous_id(&value) {
                files.embedding.insert(address.clone(), id.to_owned());
            }
            files.by_address.insert(address, (path.to_owned(), value));
        }
        files.set_default_draft();
        Ok(files)
    }

    /// The file to which a reference leads, with its address. `wanted` is an `$id`, an address or a relative path.
    fn find(&self, wanted: &str) -> Option<(&str, &Value)> {
        let name = wanted.rsplit('/').next().unwrap_or_default();
        let files = &self.by_address;
        let by_name = || files.iter().find(|(address, _)| address.rsplit('/').next() == Some(name));
        let by_id = self.by_id.get(wanted).and_then(|address| files.get_key_value(address));
        let found = by_id.or_else(|| files.get_key_value(wanted)).or_else(by_name);
        found.map(|(address, (_, value))| (address.as_str(), value))
    }

    /// The number of schemas in a file, in which each reference counts like a copy of its target.
    /// Fails with a message if a reference has no known target.
    fn count(&self, address: &str, value: &Value) -> Result<u64, String> {
        let mut anchors = Anchors::default();
        self.require_clear(address)?;
        let count = expansion::count(address, value, |document, reference| {
            let (file, fragment) = reference.split_once('#').unwrap_or((reference, ""));
            let (address, root) = self.find(if file.is_empty() { document } else { file })?;
            self.require_clear(address).ok()?;
            Some((address, anchors.fragment(root, fragment)?))
        });
        count.map_err(|reference| {
            let (file, fragment) = reference.split_once('#').unwrap_or((reference, ""));
            if let Some(Err(problem)) = self.find(file).map(|(address, _)| self.require_clear(address)) {
                return problem;
            }
            if file.is_empty() || self.find(file).is_some() {
                return format!(
                    "unknown reference: nothing in the file has the location `{}`",
                    shown(fragment)
                );
            }
            not_found(file)
        })
    }

    /// Fails with a message if references in the file have several meanings.
    fn require_clear(&self, address: &str) -> Result<(), String> {
        match self.embedding.get(address) {
            None => Ok(()),
            Some(id) => Err(format!(
                "references and an inner schema with the `$id` `{}` in one file: move that schema to its own file",
                shown(id)
            )),
        }
    }

    /// Files without `$schema` use the draft named by the first `$schema` found. Often only one file has a `$schema`.
    fn set_default_draft(&mut self) {
        let named = self.by_address.values().find_map(|(_, value)| value["$schema"].as_str());
        let Some(named) = named.map(str::to_owned) else { return };
        for (_, value) in self.by_address.values_mut() {
            if let Value::Object(members) = value {
                members.entry("$schema").or_insert_with(|| named.clone().into());
            }
        }
    }
}

/// The problem of a reference to an unknown file.
fn not_found(file: &str) -> String {
    let name = file.rsplit('/').next().unwrap_or_default();
    format!("no file in the folder is named `{}`, and remote schemas aren't fetched", shown(name))
}

/// Resolves references to files: by `$id`, by path, and finally by file name. The path in an `$id` may differ from the
/// path of its file.
struct Lookup(Arc<Files>);

impl Retrieve for Lookup {
    fn retrieve(&self, uri: &Uri<String>) -> Result<Value, Box<dyn std::error::Error + Send + Sync>> {
        let wanted = uri.as_str().split('#').next().unwrap_or_default();
        let (_, value) = self.0.find(wanted).ok_or_else(|| not_found(wanted))?;
        Ok(value.clone())
    }
}

/// A relative path in the form of a URI.
fn address(path: &Path) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let written = |byte: u8| {
        if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
    };
    path.to_string_lossy().replace('\\', "/").bytes().map(written).collect()
}

/// The message types that a schema specifies, or the type in the file name if the schema specifies none.
fn types_of(path: &Path, value: &Value) -> Vec<String> {
    let of_type = &value["properties"]["type"];
    let values = of_type["enum"].as_array().into_iter().flatten().chain([&of_type["const"]]);
    let mut types: Vec<String> = values.filter_map(Value::as_str).map(str::to_owned).collect();
    types.sort();
    types.dedup();
    if types.is_empty() {
        types.extend(words(path).find(|word| is_type(word)));
    }
    types
}

/// The direction in the name of a file.
fn direction_of(path: &Path) -> Option<Direction> {
    words(path)
        .find_map(|word| Direction::ALL.into_iter().find(|known| word.eq_ignore_ascii_case(known.name())))
}

/// The parts of a file name.
fn words(path: &Path) -> impl Iterator<Item = String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let words: Vec<String> = name.split(['.', '_', ' ']).map(str::to_owned).collect();
    words.into_iter()
}

/// True if a word looks like a message type: `SYS-VER`.
fn is_type(word: &str) -> bool {
    let is_part = |part: &str| {
        !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit())
    };
    word.contains('-') && word.split('-').all(is_part)
}

/// A tree as a JSON value. `None` if the tree contains tokens that aren't JSON, or a number beyond the range of a
/// float. If a key is repeated, its first value counts.
fn value_of(tree: &Tree<'_>) -> Option<Value> {
    Some(match tree {
        Tree::Null => Value::Null,
        Tree::Bool(value) => Value::Bool(*value),
        Tree::Int(value) => match (u64::try_from(*value), i64::try_from(*value)) {
            (Ok(value), _) => value.into(),
            (_, Ok(value)) => value.into(),
            _ => return None,
        },
        Tree::Float(value, _) => Value::Number(serde_json::Number::from_f64(*value)?),
        Tree::Huge(_) | Tree::Token(_) => return None,
        Tree::Text(text) => text.as_ref().into(),
        Tree::List(values) => Value::Array(values.iter().map(value_of).collect::<Option<_>>()?),
        Tree::Object(members) => {
            let mut object = serde_json::Map::new();
            for (key, value) in members {
                let value = value_of(value)?;
                object.entry(key.as_ref()).or_insert(value);
            }
            Value::Object(object)
        }
    })
}
