//! Shared helpers of the command-line tests.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Writes a file of a workspace and creates its folders.
pub(crate) fn write(folder: impl AsRef<Path>, path: &str, text: &str) {
    let path = folder.as_ref().join(path);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, text).expect("a file");
}

/// Runs a command in a folder.
pub(crate) fn xtask(folder: impl AsRef<Path>, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("xtask runs")
}
