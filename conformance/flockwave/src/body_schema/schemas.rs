//! User-supplied JSON Schemas for message types without a definition.

mod bundle;
mod files;
mod places;

use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jsonschema::{Draft, PatternOptions, Registry, Validator};
use serde_json::Value;
use uavspec_model::json::Tree;
use uavspec_model::text::terminal;
use uavspec_schema::json_type::Direction;

use self::bundle::{Bundle, MAX_SCHEMAS, Part};
use self::files::SchemaFile;
use self::places::Places;
use super::{DefinedSchemas, Deviation, Mismatch};

/// The maximum number of deviations to report for a body.
const MAX_DEVIATIONS: usize = 100;

/// The maximum length of a quoted part of a schema, in bytes.
const MAX_DEMAND: usize = 80;

/// The maximum total size of the compiled patterns of a file, in bytes.
const MAX_PATTERNS: usize = 16 << 20;

/// The size that every compiled pattern may have, in bytes.
const MIN_PATTERN: usize = 16 << 10;

/// The maximum number of problems to report.
const MAX_PROBLEMS: usize = 20;

/// JSON Schemas for bodies, by message type.
#[derive(Debug, Default)]
pub struct Schemas {
    by_type: BTreeMap<String, Vec<Arc<Schema>>>,
}

/// The schema in a file.
#[derive(Debug)]
struct Schema {
    file: PathBuf,
    /// The direction to which the schema applies; `None` means all directions.
    direction: Option<Direction>,
    /// The schema, and the schemas that it refers to.
    parts: Vec<Source>,
    validator: Validator,
}

/// A schema in a file.
#[derive(Debug)]
struct Source {
    file: PathBuf,
    /// The short form of the location in the file: a JSON pointer, or an anchor.
    location: String,
    value: Value,
}

/// The reasons why user-supplied schemas can't be used.
#[derive(Debug)]
pub struct SchemaError {
    problems: Vec<Problem>,
}

/// The reason why a schema can't be used.
#[derive(Debug)]
struct Problem {
    /// The file or folder.
    path: PathBuf,
    /// The location in the file, as a line and column or as a JSON pointer; may be empty.
    location: String,
    /// The reason, and how to fix it.
    reason: String,
}

impl Problem {
    fn new(path: &Path, reason: impl Into<String>) -> Self {
        Self { path: path.to_owned(), location: String::new(), reason: reason.into() }
    }
}

impl fmt::Display for SchemaError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, Problem { path, location, reason }) in self.problems.iter().enumerate() {
            let line = if number == 0 { "" } else { "\n" };
            let location = if location.is_empty() { String::new() } else { format!(":{location}") };
            write!(formatter, "{line}{}{location}: {reason}", terminal::path(path))?;
        }
        Ok(())
    }
}

impl std::error::Error for SchemaError {}

impl Schemas {
    /// Loads all `*.json` files in these folders and their subfolders. Schemas for types that have a definition are
    /// ignored. Schemas may refer to other files, but nothing is downloaded.
    pub fn load(folders: &[PathBuf], defined: &DefinedSchemas) -> Result<Self, SchemaError> {
        let mut schemas = Self::default();
        let mut problems = Vec::new();
        let mut copied = 0;
        for folder in folders {
            let loaded = schemas.load_folder(folder, defined, &mut copied, &mut problems);
            problems.extend(loaded.err());
        }
        for (type_name, known) in &mut schemas.by_type {
            leave_out_parts(known);
            problems.extend(conflict(type_name, known));
        }
        problems.truncate(MAX_PROBLEMS);
        if problems.is_empty() { Ok(schemas) } else { Err(SchemaError { problems }) }
    }

    fn load_folder(
        &mut self,
        folder: &Path,
        defined: &DefinedSchemas,
        copied: &mut usize,
        problems: &mut Vec<Problem>,
    ) -> Result<(), Problem> {
        let files = SchemaFile::read_all(folder)?;
        let places = Places::new(&files)?;
        let mut is_any = false;
        for (index, file) in files.iter().enumerate() {
            let mut types = file.types();
            is_any |= !types.is_empty();
            types.retain(|name| !defined.has(name));
            if types.is_empty() {
                continue;
            }
            match Schema::compile(&places, index, copied) {
                Ok(schema) => self.add(types, &Arc::new(schema)),
                Err(problem) => problems.push(problem),
            }
        }
        if is_any {
            return Ok(());
        }
        let problem = "no `*.json` file in this folder is a message schema: add a `const` or an `enum` to the \
                       `properties.type` of a schema, or name the file after the type, e.g. `SYS-VER.json`";
        Err(Problem::new(folder, problem))
    }

    /// Adds a schema for bodies of these types.
    fn add(&mut self, types: Vec<String>, schema: &Arc<Schema>) {
        for name in types {
            self.by_type.entry(name).or_default().push(Arc::clone(schema));
        }
    }

    /// True if there is a schema for messages of this type.
    pub(crate) fn has(&self, type_name: &str) -> bool {
        self.by_type.contains_key(type_name)
    }

    /// True if there is a schema for messages of this type in this direction.
    pub(crate) fn is_defined(&self, type_name: &str, direction: Direction) -> bool {
        self.schema(type_name, direction).is_some()
    }

    /// The schema for a type and direction. A schema for this direction takes precedence over a schema for all
    /// directions.
    fn schema(&self, type_name: &str, direction: Direction) -> Option<&Schema> {
        let schemas = self.by_type.get(type_name)?;
        let for_direction = |wanted| schemas.iter().find(|schema| schema.direction == wanted);
        for_direction(Some(direction)).or_else(|| for_direction(None)).map(Arc::as_ref)
    }

    /// The deviations of a body from its schema. `None` if there is no schema, or if the body contains values that JSON
    /// Schema can't express. Other rules report such values.
    pub fn check(&self, type_name: &str, direction: Direction, body: &Tree<'_>) -> Option<Vec<Deviation>> {
        let schema = self.schema(type_name, direction)?;
        let body = value_of(body)?;
        let errors = schema.validator.iter_errors(&body).take(MAX_DEVIATIONS);
        Some(errors.map(|error| schema.deviation(&error)).collect())
    }
}

/// Removes schemas that another schema of the same type and direction refers to: they are parts of that schema.
fn leave_out_parts(known: &mut Vec<Arc<Schema>>) {
    let is_in =
        |parts: &HashSet<_>, schema: &Schema| parts.contains(&(schema.direction, schema.file.clone()));
    let parts: HashSet<_> = known.iter().flat_map(|schema| schema.others()).collect();
    // Schemas that refer to each other don't count as parts.
    let wholes = known.iter().filter(|schema| !is_in(&parts, schema));
    let parts: HashSet<_> = wholes.flat_map(|schema| schema.others()).collect();
    known.retain(|schema| !is_in(&parts, schema));
}

/// The problem, if any, that a type has several schemas for the same direction.
fn conflict(type_name: &str, known: &[Arc<Schema>]) -> Option<Problem> {
    let (other, schema) = known.iter().enumerate().find_map(|(at, schema)| {
        let other = known[..at].iter().find(|other| other.direction == schema.direction)?;
        Some((other, schema))
    })?;
    let direction = schema.direction.map_or(String::new(), |direction| format!(" of a {direction}"));
    let problem = format!(
        "{} is also a schema for the body{direction} of {type_name}: remove one of the files, add the direction to their \
         names, or refer to one of them in the other",
        terminal::path(&other.file)
    );
    Some(Problem::new(&schema.file, problem))
}

impl Schema {
    /// Compiles the schema of a file.
    fn compile(places: &Places<'_>, file: usize, copied: &mut usize) -> Result<Self, Problem> {
        let bundle = Bundle::new(places, file, copied)?;
        for part in &bundle.parts {
            let validity = meta_schema(part.place.draft).validate(&part.value);
            validity.map_err(|error| invalid(places, part, &error))?;
        }
        let root = places.file(places.root(file));
        if !bundle.size().is_small() {
            let problem =
                format!("too many references: expanded, they yield more than {MAX_SCHEMAS} schemas");
            return Err(Problem::new(&root.path, problem));
        }
        let Bundle { parts, patterns, .. } = bundle;
        let validator = validator(&parts, patterns).map_err(|error| {
            let part = part_of(&error).and_then(|part| parts.get(part)).unwrap_or(&parts[0]);
            invalid(places, part, &error)
        })?;
        let source = |part: Part<'_>| Source {
            file: places.file(part.place).path.clone(),
            location: part.location,
            value: part.value,
        };
        let parts = parts.into_iter().map(source).collect();
        Ok(Self { file: root.path.clone(), direction: root.direction(), parts, validator })
    }

    /// The other files that this schema refers to as a whole rather than to a part of them, each with the direction of
    /// this schema.
    fn others(&self) -> impl Iterator<Item = (Option<Direction>, PathBuf)> {
        let is_whole = |part: &&Source| part.location.is_empty() && part.file != self.file;
        self.parts.iter().filter(is_whole).map(|part| (self.direction, part.file.clone()))
    }

    fn deviation(&self, error: &jsonschema::ValidationError<'_>) -> Deviation {
        let part = part_of(error).and_then(|part| self.parts.get(part)).unwrap_or(&self.parts[0]);
        let at = error.schema_path().to_string();
        let demand = part.value.pointer(&at).map(|demand| format!(": {}", shortened(demand)));
        let expected = format!(
            "a value that matches {} at {}{at}{}",
            terminal::path(&part.file),
            part.location,
            demand.unwrap_or_default()
        );
        let actual = match error.instance().as_ref() {
            Value::Array(values) => format!("an array of {}", values.len()),
            Value::Object(_) => "an object".to_owned(),
            other => {
                Tree::read(&other.to_string()).map_or_else(|error| error.to_string(), |tree| tree.to_string())
            }
        };
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

/// The start of a schema's text.
fn shortened(schema: &Value) -> String {
    let mut text = [0; MAX_DEMAND];
    let mut rest = &mut text[..];
    // Writing stops when the space is used up.
    let more = if serde_json::to_writer(&mut rest, schema).is_ok() { "" } else { "…" };
    let length = MAX_DEMAND - rest.len();
    let text = String::from_utf8_lossy(&text[..length]);
    format!("{}{more}", text.trim_end_matches(char::REPLACEMENT_CHARACTER))
}

/// Compiles the first part. All patterns together have a maximum size in memory.
fn validator(parts: &[Part<'_>], patterns: usize) -> Result<Validator, jsonschema::ValidationError<'static>> {
    let limit = (MAX_PATTERNS / patterns.max(1)).max(MIN_PATTERN);
    let mut registry = Registry::new();
    for (number, part) in parts.iter().enumerate().skip(1) {
        let resource = part.place.draft.create_resource_ref(&part.value);
        registry = registry.add(bundle::address(number), resource)?;
    }
    let registry = registry.prepare()?;
    jsonschema::options()
        .with_draft(parts[0].place.draft)
        .with_base_uri(bundle::address(0))
        .with_registry(&registry)
        .with_pattern_options(PatternOptions::fancy_regex().size_limit(limit).dfa_size_limit(limit))
        .build(&parts[0].value)
}

/// The part that contains the violated keyword.
fn part_of(error: &jsonschema::ValidationError<'_>) -> Option<usize> {
    let (address, _) = error.absolute_keyword_location()?.as_str().split_once('#')?;
    address.rsplit('/').next()?.parse().ok()
}

fn invalid(places: &Places<'_>, part: &Part<'_>, error: &jsonschema::ValidationError<'_>) -> Problem {
    places.problem(part.place, error.instance_path().as_str(), format!("invalid JSON Schema: {error}"))
}

/// The schema of schemas.
fn meta_schema(draft: Draft) -> jsonschema::meta::MetaValidator<'static> {
    match draft {
        Draft::Draft4 => jsonschema::draft4::meta::validator(),
        Draft::Draft6 => jsonschema::draft6::meta::validator(),
        Draft::Draft7 => jsonschema::draft7::meta::validator(),
        Draft::Draft201909 => jsonschema::draft201909::meta::validator(),
        _ => jsonschema::draft202012::meta::validator(),
    }
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

#[cfg(test)]
mod tests;
