//! Python with third-party packages, for tests that are ignored by default.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The path of Python in a folder of `target`, with these packages installed. Installs them if the folder contains
/// other packages.
pub fn python(folder: &str, packages: &[&str]) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target").join(folder);
    let (program, installed) = (folder.join("bin/python"), folder.join("requirements.txt"));
    let list = packages.join("\n");
    if fs::read_to_string(&installed).ok().as_ref() != Some(&list) {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder));
        run(Command::new(&program).args(["-m", "pip", "install", "--quiet"]).args(packages));
        fs::write(installed, list).expect("a file");
    }
    program
}

/// Runs a command. Panics if it fails.
pub fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(status.success(), "{command:?} failed: {status}");
}
