//! Shared helpers of the command-line tests.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A configuration with one package, whose definitions are in `msg`.
pub(crate) const CONFIG: &str =
    "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n";

/// A temporary folder with these files.
pub(crate) fn workspace(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (path, text) in files {
        write(&folder, path, text);
    }
    folder
}

/// Writes a file of a workspace and creates its folders.
pub(crate) fn write(folder: impl AsRef<Path>, path: &str, text: &str) {
    let path = folder.as_ref().join(path);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, text).expect("a file");
}

/// Reads a file of a workspace.
#[track_caller]
pub(crate) fn read(folder: impl AsRef<Path>, path: &str) -> String {
    fs::read_to_string(folder.as_ref().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// All files in a folder with their content, and all empty folders in it.
pub(crate) fn tree(folder: impl AsRef<Path>) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in walkdir::WalkDir::new(&folder).min_depth(1).sort_by_file_name() {
        let entry = entry.expect("an entry");
        let path = entry.path();
        if !entry.file_type().is_dir() || fs::read_dir(path).expect("a folder").next().is_none() {
            let name = path.strip_prefix(&folder).expect("a path below the folder");
            files.push((name.display().to_string(), fs::read(path).unwrap_or_default()));
        }
    }
    files
}

/// Runs a command in a folder.
pub(crate) fn xtask(folder: impl AsRef<Path>, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("xtask runs")
}

/// Runs a command, which must end with this status. Returns standard output and standard error.
#[track_caller]
pub(crate) fn run(folder: impl AsRef<Path>, arguments: &[&str], status: i32) -> (String, String) {
    let output = xtask(folder, arguments);
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let (results, errors) = (text(output.stdout), text(output.stderr));
    assert_eq!(output.status.code(), Some(status), "{arguments:?}\n{results}{errors}");
    (results, errors)
}
