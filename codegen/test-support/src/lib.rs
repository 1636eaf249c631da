//! Helpers of tests: the corpus, and packages that are read from folders or texts.

#![allow(clippy::missing_panics_doc, reason = "a panic is the failure of a test")]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use lzma_rust2::{XzOptions, XzWriter};
use proptest::test_runner::Config;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Diagnostic, Form, PackageInput, Schema, SourceMap, read};

/// A folder next to the corpus, such as `corpus/px4` or `oracle/uorb`, or `None` if the corpus is absent.
///
/// # Panics
///
/// Panics if the folder is absent and `UAVSPEC_REQUIRE_CORPUS` is set.
pub fn shared(path: &str) -> Option<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/corpus");
    let corpus = std::env::var_os("UAVSPEC_CORPUS").map_or(default, PathBuf::from);
    let found = corpus.parent()?.join(path);
    if found.exists() {
        return Some(found);
    }
    assert!(
        std::env::var_os("UAVSPEC_REQUIRE_CORPUS").is_none_or(|value| value == "0"),
        "{} is required but absent",
        found.display()
    );
    eprintln!("skipped: {path} is absent; set UAVSPEC_CORPUS to the path of the corpus");
    None
}

/// `full` if `UAVSPEC_TEST_THOROUGH` is set, as in `.ci/run --release`; otherwise `quick`.
pub fn extent<T>(full: T, quick: T) -> T {
    if std::env::var_os("UAVSPEC_TEST_THOROUGH").is_some_and(|value| value != "0") { full } else { quick }
}

/// The configuration of a property test with this number of cases. A quick run tries a sixteenth of the cases, with a
/// minimum of 16 cases. Proptest doesn't save failing cases to files, because developers turn each of them into a test
/// or a fixture.
pub fn config(cases: u32) -> Config {
    let quick = (cases / 16).max(16).min(cases);
    Config { failure_persistence: None, cases: extent(cases, quick), ..Config::default() }
}

/// Like `config`, with a multiple of the default number of cases. `PROPTEST_CASES` sets the default.
pub fn usual(times: u32) -> Config {
    config(Config::default().cases * times)
}

/// A package without sources.
pub fn package(name: &str, form: Form) -> PackageInput {
    PackageInput::new(name, form, Vec::new())
}

/// All files below `folder` whose extension is one of `extensions`, sorted.
pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the corpus") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path
                .extension()
                .is_some_and(|found| extensions.iter().any(|extension| found == *extension))
            {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Adds the definitions below `folder` to `package`.
pub fn add_folder(sources: &mut SourceMap, package: &mut PackageInput, folder: &Path) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for path in files_below(folder, &["msg", "srv", "action"]) {
        match sources.add(path.to_string_lossy(), fs::read(&path).expect("a readable file")) {
            Ok(id) => package.sources.push(id),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    diagnostics
}

/// Reads a release of PX4 from the corpus.
pub fn px4(folder: &Path) -> (SourceMap, Schema, Vec<Diagnostic>) {
    let mut sources = SourceMap::default();
    let mut package = package("px4", Form::Msg(Dialect::Px4));
    let mut diagnostics = add_folder(&mut sources, &mut package, folder);
    let (schema, mut found) = read(&sources, &[package]);
    diagnostics.append(&mut found);
    (sources, schema, diagnostics)
}

/// Reads all ROS 2 packages in the subfolders of a folder.
pub fn ros2(folder: &Path) -> (SourceMap, Schema, Vec<Diagnostic>) {
    let mut sources = SourceMap::default();
    let mut packages = Vec::new();
    let mut diagnostics = Vec::new();
    let mut folders: Vec<PathBuf> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    folders.sort();
    for folder in folders.into_iter().filter(|path| path.is_dir()) {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        let mut package = package(&name, Form::Msg(Dialect::Ros2));
        diagnostics.append(&mut add_folder(&mut sources, &mut package, &folder));
        packages.push(package);
    }
    let (schema, mut found) = read(&sources, &packages);
    diagnostics.append(&mut found);
    (sources, schema, diagnostics)
}

/// Reads files, given by name and text.
pub fn texts(form: Form, files: &[(&str, &str)]) -> (SourceMap, Schema, Vec<Diagnostic>) {
    let mut sources = SourceMap::default();
    let mut package = package("demo", form);
    let mut diagnostics = Vec::new();
    for (path, text) in files {
        match sources.add(*path, text.as_bytes().to_vec()) {
            Ok(id) => package.sources.push(id),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let (schema, mut found) = read(&sources, &[package]);
    diagnostics.append(&mut found);
    (sources, schema, diagnostics)
}

/// Compresses bytes with xz.
pub fn xz(bytes: &[u8]) -> Vec<u8> {
    let mut writer = XzWriter::new(Vec::new(), XzOptions::with_preset(0)).expect("valid options");
    writer.write_all(bytes).and_then(|()| writer.finish()).expect("compressed bytes")
}

/// Compares `found` with the file at `path`, and returns the difference. With `UAVSPEC_UPDATE_FIXTURES`, writes the
/// file instead.
pub fn differs(path: &Path, found: &str) -> Option<String> {
    let expected = fs::read_to_string(path).unwrap_or_default();
    if found == expected {
        return None;
    }
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(path, found).expect("a writable file");
        return None;
    }
    Some(format!("{}: found\n{found}expected\n{expected}", path.display()))
}
