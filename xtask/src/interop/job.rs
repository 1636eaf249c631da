//! The jobs for each tool: the cases of the vectors, with the published schemas.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use serde_json::{Value, json};
use walkdir::{DirEntry, WalkDir};

/// The way to refer to a schema.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Form {
    /// By its own URL. The schema refers to other files.
    Files,
    /// By its location in the package's bundle. The bundle doesn't refer to other files.
    Bundle,
}

impl Form {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Files => "files",
            Self::Bundle => "bundle",
        }
    }
}

/// A schema and its cases.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Job {
    pub(super) form: Form,
    /// The type, with its package.
    pub(super) name: String,
    /// The URL of the schema.
    pub(super) schema: String,
    pub(super) cases: Vec<Case>,
}

impl Job {
    pub(super) fn package(&self) -> &str {
        self.name.split_once('/').map_or("", |(package, _)| package)
    }
}

/// An instance and the expected result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Case {
    pub(super) id: String,
    /// The instance exactly as in the vectors, because tools parse numbers differently.
    pub(super) text: String,
    /// True if the schema accepts the instance.
    pub(super) is_valid: bool,
    /// The violated rule, if a schema can't express it.
    pub(super) beyond: Option<String>,
}

/// All jobs, and the documents that they require.
#[derive(Debug)]
pub(super) struct Jobs {
    /// The paths of the schemas, by URL.
    documents: BTreeMap<String, PathBuf>,
    pub(super) list: Vec<Job>,
}

#[derive(Deserialize)]
struct Vectors {
    #[serde(rename = "type")]
    name: String,
    schema: String,
    cases: Vec<Vector>,
}

#[derive(Deserialize)]
struct Vector {
    id: String,
    valid: bool,
    rule: Option<String>,
    json: Option<Box<RawValue>>,
}

impl Jobs {
    /// Reads the generated files in `folder`.
    pub(super) fn read(folder: &Path) -> Result<Self, String> {
        let mut documents = BTreeMap::new();
        let mut bundles = BTreeMap::new();
        let mut schemas = files(&folder.join("schemas"), ".schema.json")?;
        schemas.push(folder.join("vectors/vectors.schema.json"));
        for path in schemas {
            let document: Value = parse(&path)?;
            let address = document["$id"].as_str().ok_or_else(|| format!("{}: no `$id`", path.display()))?;
            if let Some((package, _)) = name_of(&path).split_once(".bundle.") {
                bundles.insert(package.to_owned(), (address.to_owned(), document["$defs"].clone()));
            }
            documents.insert(address.to_owned(), path);
        }
        let mut list = Vec::new();
        for path in files(&folder.join("vectors"), ".vectors.json")? {
            let vectors: Vectors = parse(&path)?;
            let (package, name) = vectors
                .name
                .split_once('/')
                .ok_or_else(|| format!("{}: `type` contains no package", path.display()))?;
            let cases = cases(folder, &path, vectors.cases)?;
            let job = |form, schema| Job { form, name: vectors.name.clone(), schema, cases: cases.clone() };
            list.push(job(Form::Files, vectors.schema.clone()));
            if let Some((address, definitions)) = bundles.get(package) {
                let definition = name_of(&path).trim_end_matches(".vectors.json");
                if definitions.get(definition).is_none() {
                    return Err(format!(
                        "{address} doesn't define `{definition}`, but {name} has vectors for it"
                    ));
                }
                list.push(job(Form::Bundle, format!("{address}#/$defs/{definition}")));
            }
        }
        list.sort_by(|left, right| (left.form, &left.name).cmp(&(right.form, &right.name)));
        if list.is_empty() {
            return Err(format!(
                "{}: no vectors; generate them with `cargo xtask codegen`",
                folder.display()
            ));
        }
        Ok(Self { documents, list })
    }

    /// The input file of adapters, with a line for each document and each job.
    pub(super) fn text(&self) -> String {
        let documents =
            self.documents.iter().map(|(address, path)| json!({ "document": address, "path": path }));
        let jobs = self.list.iter().enumerate().map(|(index, job)| {
            let cases: Vec<&str> = job.cases.iter().map(|case| case.text.as_str()).collect();
            json!({ "job": index, "schema": job.schema, "cases": cases })
        });
        documents.chain(jobs).map(|line| format!("{line}\n")).collect()
    }

    /// The number of violating cases for each rule that schemas can't express.
    pub(super) fn beyond_schemas(&self) -> BTreeMap<String, usize> {
        let mut rules = BTreeMap::new();
        for case in self.list.iter().filter(|job| job.form == Form::Files).flat_map(|job| &job.cases) {
            if let Some(rule) = &case.beyond {
                *rules.entry(rule.clone()).or_default() += 1;
            }
        }
        rules
    }
}

/// The cases that have a JSON form. The expected results come from the files in the format of the JSON Schema Test
/// Suite. These files omit cases on which tools disagree. The results of the omitted cases come from the vectors.
fn cases(folder: &Path, path: &Path, vectors: Vec<Vector>) -> Result<Vec<Case>, String> {
    let root = folder.join("vectors");
    let relative = path.strip_prefix(&root).map_err(|error| error.to_string())?;
    let suite = root.join("json-schema-test-suite/tests/draft2020-12").join(relative);
    let suite = suite.with_file_name(name_of(path).replace(".vectors.json", ".json"));
    let groups: Vec<Value> = if suite.exists() { parse(&suite)? } else { Vec::new() };
    let tests = groups.iter().filter_map(|group| group["tests"].as_array()).flatten();
    let verdicts: BTreeMap<&str, bool> = tests
        .filter_map(|test| {
            Some((test["description"].as_str()?.split_once(": ")?.0, test["valid"].as_bool()?))
        })
        .collect();
    let case = |vector: Vector| {
        let is_valid = verdicts.get(vector.id.as_str()).copied().unwrap_or(vector.valid);
        Some(Case {
            text: vector.json?.get().to_owned(),
            beyond: vector.rule.filter(|_| is_valid && !vector.valid),
            is_valid,
            id: vector.id,
        })
    };
    Ok(vectors.into_iter().filter_map(case).collect())
}

/// The files below `folder` with this ending.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, String> {
    let paths = WalkDir::new(folder).into_iter().map(|entry| entry.map(DirEntry::into_path));
    let paths: Vec<PathBuf> = paths.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
    Ok(paths.into_iter().filter(|path| name_of(path).ends_with(ending)).collect())
}

fn name_of(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap_or_default()
}

pub(super) fn parse<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}
