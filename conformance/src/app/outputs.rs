//! Protects the files of a run: an output never replaces an input or another output.
//!
//! Files are compared by identity, so different spellings of a path, symbolic links and hard links are detected. Pipes
//! and devices aren't compared, because writing to them replaces nothing.

use std::path::{Path, PathBuf};

use uavspec_capture::rosbag::metadata::files_of;
use uavspec_codegen::load::definition_files;
use uavspec_model::text::terminal;
use uavspec_schema::identity::Identity;
use walkdir::WalkDir;

use super::Status;

/// The path that means standard input or standard output.
const STANDARD: &str = "-";

/// The files that a run reads.
#[derive(Default)]
pub(super) struct Inputs<'a> {
    /// Files, and folders of bags. `-` means standard input.
    pub(super) files: Vec<&'a Path>,
    /// The paths of definitions.
    pub(super) definitions: Vec<&'a Path>,
    /// The folders with JSON Schemas.
    pub(super) schemas: &'a [PathBuf],
}

/// A file that a run writes.
pub(super) struct Output<'a> {
    /// The option and its value, for messages, such as `--record run.jsonl`.
    pub(super) name: String,
    /// The path; `-` means standard output.
    pub(super) path: &'a Path,
}

impl<'a> Output<'a> {
    /// The file that an option names.
    pub(super) fn new(option: &str, path: &'a Path) -> Self {
        Self { name: format!("{option} {}", terminal::path(path)), path }
    }
}

/// An output with the identity of its file.
struct Target {
    name: String,
    identity: Identity,
}

/// Fails if an output is an input, or is the same file as another output. Prints errors.
pub(super) fn check(inputs: &Inputs<'_>, outputs: &[Output<'_>]) -> Result<(), Status> {
    let help = "choose another file for the output";
    problem(inputs, outputs).map_or(Ok(()), |problem| Err(Status::Usage.with_help(problem, help)))
}

fn problem(inputs: &Inputs<'_>, outputs: &[Output<'_>]) -> Option<String> {
    let named = outputs.iter().filter(|output| output.path != Path::new(STANDARD));
    let targets: Vec<Target> = named.filter_map(Target::of).chain(Target::standard_output()).collect();
    shared(&targets).or_else(|| overwritten(inputs, &targets))
}

/// The error if two outputs are the same file.
fn shared(targets: &[Target]) -> Option<String> {
    targets.iter().enumerate().find_map(|(at, target)| {
        let other = targets[..at].iter().find(|other| target.identity.is_same(&other.identity))?;
        Some(format!("{} and {} are the same file", other.name, target.name))
    })
}

/// The error if an output is an input.
fn overwritten(inputs: &Inputs<'_>, targets: &[Target]) -> Option<String> {
    if targets.is_empty() {
        return None;
    }
    // Definitions that can't be read are reported elsewhere.
    let definitions = inputs.definitions.iter().filter_map(|path| definition_files(path).ok()).flatten();
    let schemas = inputs.schemas.iter().flat_map(|folder| schema_files(folder));
    let found = definitions.chain(schemas);
    let mut files = inputs.files.iter().flat_map(|path| files_of(path)).chain(found);
    files.find_map(|path| {
        let input = identity_of(&path)?;
        let target = targets.iter().find(|target| target.identity.is_same(&input))?;
        let path = terminal::path(&path);
        Some(format!("{} would overwrite the input {path}", target.name))
    })
}

/// The JSON files in a folder and its subfolders.
fn schema_files(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let files = WalkDir::new(folder).into_iter().filter_map(Result::ok).map(walkdir::DirEntry::into_path);
    files.filter(|path| path.extension().is_some_and(|extension| extension == "json"))
}

impl Target {
    /// The target of an output. `None` for pipes, devices and folders.
    fn of(output: &Output<'_>) -> Option<Self> {
        Some(Self { name: output.name.clone(), identity: Identity::of(output.path)? })
    }

    /// Standard output, if it is redirected to a file.
    fn standard_output() -> Option<Self> {
        Some(Self { name: "standard output".to_owned(), identity: Identity::standard_output()? })
    }
}

/// The identity of an input.
fn identity_of(input: &Path) -> Option<Identity> {
    if input == Path::new(STANDARD) { Identity::standard_input() } else { Identity::of(input) }
}
