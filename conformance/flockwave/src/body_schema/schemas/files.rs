//! The files in a folder with JSON Schemas.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use jsonschema::Draft;
use serde_json::Value;
use uavspec_schema::json_type::Direction;
use walkdir::WalkDir;

use super::Problem;

/// The maximum total size of the files in a folder, in bytes.
const MAX_BYTES: usize = 16 << 20;

/// The maximum number of values in all files of a folder. A value takes more memory than its text. The protocol's
/// published schemas contain fewer than 10,000.
const MAX_VALUES: usize = 200_000;

/// A file with a JSON Schema, or with definitions for other files.
#[derive(Debug)]
pub(super) struct SchemaFile {
    pub path: PathBuf,
    /// The path in the folder, as a relative URI.
    pub address: String,
    /// The draft of JSON Schema that the file uses. `Draft::Unknown` if its `$schema` names another language.
    pub draft: Draft,
    pub value: Value,
}

impl SchemaFile {
    /// Reads all `*.json` files in a folder and its subfolders.
    pub(super) fn read_all(folder: &Path) -> Result<Vec<Self>, Problem> {
        let mut files = Vec::new();
        let (mut bytes, mut values) = (0, 0);
        for entry in WalkDir::new(folder).sort_by_file_name() {
            let entry = entry.map_err(|error| unreadable(folder, &error))?;
            let path = entry.path();
            if !entry.file_type().is_file() || path.extension().is_none_or(|extension| extension != "json") {
                continue;
            }
            let text = read(path, MAX_BYTES - bytes)?;
            bytes += text.len();
            values += count_values(&text);
            if values > MAX_VALUES {
                let limit = format!("the `*.json` files in the folder contain more than {MAX_VALUES} values");
                return Err(Problem::new(path, limit));
            }
            files.push(Self::parse(folder, path, &text)?);
        }
        set_default_draft(&mut files);
        Ok(files)
    }

    fn parse(folder: &Path, path: &Path, text: &str) -> Result<Self, Problem> {
        let value = serde_json::from_str(text).map_err(|error| Problem {
            location: format!("{}:{}", error.line(), error.column()),
            ..Problem::new(path, format!("invalid JSON: {error}"))
        })?;
        let address = address(&path.strip_prefix(folder).unwrap_or(path).to_string_lossy());
        Ok(Self { path: path.to_owned(), address, draft: Draft::default(), value })
    }

    /// The message types of bodies that the schema describes, or the type in the file name if the schema names none.
    pub(super) fn types(&self) -> Vec<String> {
        let of_type = &self.value["properties"]["type"];
        let values = of_type["enum"].as_array().into_iter().flatten().chain([&of_type["const"]]);
        let mut types: Vec<String> = values.filter_map(Value::as_str).map(str::to_owned).collect();
        types.sort();
        types.dedup();
        // Examples of messages have the same names as schemas.
        let is_message = self.value["type"].as_str().is_some_and(is_type);
        if types.is_empty() && !is_message {
            types.extend(self.words().find(|word| is_type(word)));
        }
        types
    }

    /// The direction in the name of the file.
    pub(super) fn direction(&self) -> Option<Direction> {
        self.words()
            .find_map(|word| Direction::ALL.into_iter().find(|known| word.eq_ignore_ascii_case(known.name())))
    }

    /// The parts of the file name.
    fn words(&self) -> impl Iterator<Item = String> {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let words: Vec<String> = name.split(['.', '_', ' ']).map(str::to_owned).collect();
        words.into_iter()
    }
}

fn unreadable(folder: &Path, error: &walkdir::Error) -> Problem {
    let reason =
        error.io_error().map_or_else(|| "a symbolic link forms a loop".to_owned(), ToString::to_string);
    Problem::new(error.path().unwrap_or(folder), format!("can't be read: {reason}"))
}

fn read(path: &Path, limit: usize) -> Result<String, Problem> {
    let mut text = String::new();
    File::open(path)
        .and_then(|file| file.take(limit as u64 + 1).read_to_string(&mut text))
        .map_err(|error| Problem::new(path, format!("can't be read: {error}")))?;
    if text.len() > limit {
        let limit = format!("the `*.json` files in the folder are larger than {MAX_BYTES} bytes");
        return Err(Problem::new(path, limit));
    }
    Ok(text)
}

/// An upper bound of the number of values in a JSON text: each value but the first follows one of these characters.
fn count_values(text: &str) -> usize {
    1 + text.bytes().filter(|byte| b",:[".contains(byte)).count()
}

/// Files without `$schema` use the first draft that a file names. Often only one file has a `$schema`.
fn set_default_draft(files: &mut [SchemaFile]) {
    let mut default = None;
    for file in &mut *files {
        if let Some(draft) = own_draft(&file.value) {
            file.draft = draft;
            default = default.or((draft != Draft::Unknown).then_some(draft));
        }
    }
    for file in files.iter_mut().filter(|file| own_draft(&file.value).is_none()) {
        file.draft = default.unwrap_or_default();
    }
}

/// The draft that a schema names.
pub(super) fn own_draft(value: &Value) -> Option<Draft> {
    value.get("$schema")?.as_str().map(Draft::from_schema_uri)
}

/// A relative path in the form of a URI.
pub(super) fn address(path: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte);
    let written = |byte: u8| {
        if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
    };
    path.replace('\\', "/").bytes().map(written).collect()
}

/// True if a word looks like a message type: `SYS-VER`.
fn is_type(word: &str) -> bool {
    let is_part = |part: &str| {
        !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit())
    };
    word.contains('-') && word.split('-').all(is_part)
}
