//! Protects the files of a run: an output never replaces an input or another output.
//!
//! Files are compared by identity, so other spellings of a path, symbolic links and hard links make no difference.
//! Pipes and devices are not compared, because writing to them replaces nothing.

use std::env;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use same_file::Handle;
use uavspec_codegen::load::definition_files;
use walkdir::WalkDir;

use super::Status;
use crate::capture::rosbag::metadata::files_of;
use crate::text::terminal;

/// The path that means standard input or standard output.
const STANDARD: &str = "-";

/// The maximum number of symbolic links to follow, as on Linux.
const MAX_LINKS: usize = 40;

/// The files that a run reads.
#[derive(Default)]
pub(super) struct Inputs<'a> {
    /// Files and folders of bags; `-` means standard input.
    pub(super) files: Vec<&'a Path>,
    /// The paths of definitions.
    pub(super) definitions: Vec<&'a Path>,
    /// The folders with JSON Schemas.
    pub(super) schemas: &'a [PathBuf],
}

/// A file that a run writes.
pub(super) struct Output<'a> {
    /// The name in messages, such as `--record run.jsonl`.
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

/// An output with its identity.
struct Target {
    name: String,
    /// The path with all links resolved.
    path: PathBuf,
    /// The file, if it exists.
    handle: Option<Handle>,
}

/// Returns an error if an output is an input, or the same file as another output. Errors are printed.
pub(super) fn check(inputs: &Inputs<'_>, outputs: &[Output<'_>]) -> Result<(), Status> {
    problem(inputs, outputs).map_or(Ok(()), |problem| {
        terminal::error(&problem, Some("choose another file for the output"));
        Err(Status::Usage)
    })
}

fn problem(inputs: &Inputs<'_>, outputs: &[Output<'_>]) -> Option<String> {
    let named = outputs.iter().filter(|output| output.path != Path::new(STANDARD));
    let targets: Vec<Target> = named.filter_map(Target::of).chain(Target::standard_output()).collect();
    shared(&targets).or_else(|| overwritten(inputs, &targets))
}

/// The error for two outputs that are the same file.
fn shared(targets: &[Target]) -> Option<String> {
    targets.iter().enumerate().find_map(|(at, target)| {
        let other = targets[..at].iter().find(|other| target.is_same(other))?;
        Some(format!("{} and {} are the same file", other.name, target.name))
    })
}

/// The error for an output that is an input.
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
        let target = targets.iter().find(|target| target.is_input(&path))?;
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
    /// The target of an output; `None` for pipes, devices and folders.
    fn of(output: &Output<'_>) -> Option<Self> {
        let Output { name, path } = output;
        let is_replaceable = fs::metadata(path).map_or(true, |metadata| metadata.is_file());
        let handle = || Handle::from_path(path).ok();
        is_replaceable.then(|| Self { name: name.clone(), path: real_path(path), handle: handle() })
    }

    /// Standard output, if it is redirected to a file.
    fn standard_output() -> Option<Self> {
        let handle = Handle::stdout().ok().filter(|handle| is_file(handle.as_file()))?;
        Some(Self { name: "standard output".to_owned(), path: PathBuf::new(), handle: Some(handle) })
    }

    fn is_same(&self, other: &Self) -> bool {
        match (&self.handle, &other.handle) {
            (Some(handle), Some(other)) => handle == other,
            _ => is_same_path(&self.path, &other.path),
        }
    }

    fn is_input(&self, path: &Path) -> bool {
        if path == Path::new(STANDARD) {
            let handle = Handle::stdin().ok().filter(|handle| is_file(handle.as_file()));
            return handle.is_some() && handle == self.handle;
        }
        // Opening a pipe would take data from its reader.
        let is_other = fs::metadata(path).is_ok_and(|metadata| !metadata.is_file());
        let input = if is_other { None } else { Handle::from_path(path).ok() };
        match (input, &self.handle) {
            _ if is_other => false,
            (Some(input), Some(handle)) => input == *handle,
            _ => is_same_path(&real_path(path), &self.path),
        }
    }
}

fn is_file(file: &File) -> bool {
    file.metadata().is_ok_and(|metadata| metadata.is_file())
}

/// Compares the real paths of files that don't exist yet.
fn is_same_path(left: &Path, right: &Path) -> bool {
    if cfg!(any(windows, target_os = "macos")) {
        // The file systems usually ignore case.
        return left.to_string_lossy().to_lowercase() == right.to_string_lossy().to_lowercase();
    }
    left == right
}

/// The path of a file, with all links resolved. The file may be absent.
fn real_path(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let Ok(target) = fs::read_link(&path) else { break };
        path = path.parent().map_or_else(|| target.clone(), |parent| parent.join(&target));
    }
    fs::canonicalize(&path).or_else(|_| real_path_of_absent(&path)).unwrap_or(path)
}

fn real_path_of_absent(path: &Path) -> io::Result<PathBuf> {
    let absolute = env::current_dir()?.join(path);
    let (Some(parent), Some(name)) = (absolute.parent(), absolute.file_name()) else { return Ok(absolute) };
    Ok(fs::canonicalize(parent)?.join(name))
}
