//! Tests of the formatter: the meaning is preserved, the result matches the fixtures, and a second run changes nothing.
//!
//! Each folder in `fixtures/format` is a case: an `in.*` file to format, and an `out.*` file with the expected result.
//! A `dialect` file selects `ros2` instead of `px4`. To accept intended changes: `UAVSPEC_UPDATE_FIXTURES=1 cargo test
//! -p uavspec-lint format::`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use support::{extent, files_below, shared};
use uavspec_schema::Form;
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_test_definitions as support;

use crate::layout::{check_files, laid_out};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/format")
}

/// The difference between a case and its expected result, if any.
fn check_fixture(folder: &Path) -> Option<String> {
    let is_ros2 = fs::read_to_string(folder.join("dialect")).is_ok_and(|dialect| dialect.trim() == "ros2");
    let file = |name: &str| {
        let mut entries =
            fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        entries.find(|path| path.file_stem().is_some_and(|stem| stem == name))
    };
    let input = file("in").expect("a file `in`");
    let extension = input.extension().expect("an extension").to_string_lossy().into_owned();
    let form = match Kind::of(&input.to_string_lossy()) {
        None => Form::Table,
        Some(_) if is_ros2 => Form::Msg(Dialect::Ros2),
        Some(_) => Form::Msg(Dialect::Px4),
    };
    let text = fs::read_to_string(&input).expect("a text");
    let found = match check_files(form, &[(format!("Case.{extension}"), text.clone())]) {
        Ok(_) => laid_out(&format!("Case.{extension}"), &text, form),
        Err(problem) => return Some(problem),
    };
    let found = found.expect("checked").text;
    let output = folder.join(format!("out.{extension}"));
    let expected = fs::read_to_string(&output).unwrap_or_default();
    if found == expected {
        return None;
    }
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(&output, found).expect("a writable file");
        return None;
    }
    Some(format!("{} found\n{found}expected\n{expected}", folder.display()))
}

#[test]
fn formats_fixtures_as_expected() {
    let mut failures = String::new();
    let mut folders: Vec<PathBuf> =
        fs::read_dir(fixtures()).expect("fixtures").map(|entry| entry.expect("an entry").path()).collect();
    folders.sort();
    for failure in folders.iter().filter_map(|folder| check_fixture(folder)) {
        writeln!(failures, "{failure}").expect("a string");
    }
    assert!(failures.is_empty(), "{failures}UAVSPEC_UPDATE_FIXTURES=1 accepts the result");
}

fn texts(files: Vec<PathBuf>) -> Vec<(String, String)> {
    let text = |path: PathBuf| {
        fs::read_to_string(&path).ok().map(|text| (path.to_string_lossy().into_owned(), text))
    };
    files.into_iter().filter_map(text).collect()
}

/// All folders of the corpus that are packages, with their dialect. A quick run omits the older releases of PX4, and most
/// of the changes.
fn packages(corpus: &Path) -> Vec<(PathBuf, Dialect)> {
    let below = |path: &str, dialect| {
        let entries = fs::read_dir(corpus.join(path)).expect("a folder of the corpus");
        let folders = entries.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir());
        folders.map(|folder| (folder, dialect)).collect::<Vec<_>>()
    };
    let changes = below("breaking", Dialect::Px4).into_iter();
    let changes = changes.flat_map(|(folder, dialect)| ["old", "new"].map(|at| (folder.join(at), dialect)));
    // An odd step keeps both old and new files.
    let mut packages: Vec<_> = changes.step_by(extent(1, 9)).collect();
    let is_wanted = |folder: &Path| extent(true, folder.ends_with("main"));
    packages.extend(below("px4", Dialect::Px4).into_iter().filter(|(folder, _)| is_wanted(folder)));
    packages.extend(below("ros2", Dialect::Ros2));
    packages
}

#[test]
fn preserves_the_meaning_of_definitions_in_the_corpus() {
    let Some(corpus) = shared("corpus") else { return };
    let mut count = 0;
    for (folder, dialect) in packages(&corpus) {
        let files = files_below(&folder, &["msg", "srv", "action"]);
        let files = texts(files.into_iter().step_by(extent(1, 9)).collect());
        let laid_out = check_files(Form::Msg(dialect), &files).unwrap_or_else(|problem| panic!("{problem}"));
        count += laid_out;
    }
    assert!(count > extent(900, 40), "{count} files");
}

#[test]
fn preserves_the_meaning_of_specification_pages() {
    let Some(folder) = shared("spec") else { return };
    for (path, text) in texts(files_below(&folder, &["md", "adoc", "txt"])) {
        check_files(Form::Table, &[(path, text)]).unwrap_or_else(|problem| panic!("{problem}"));
    }
}

#[test]
fn our_own_definitions_are_formatted() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions");
    for (sub, form) in [("px4", Form::Msg(Dialect::Px4)), ("flockwave", Form::Table)] {
        for (path, text) in texts(files_below(&folder.join(sub), &["msg", "md"])) {
            let found = laid_out(&path, &text, form).expect("no errors");
            assert!(found.text == text && !found.is_kept, "{path}: run `cargo xtask fmt`\n{}", found.text);
        }
    }
}

#[test]
fn reports_all_errors() {
    let diagnostics =
        laid_out("A.msg", "uint8 A = 300\nuint8[0] b\n", Form::Msg(Dialect::Px4)).expect_err("two errors");
    assert!(has_errors(&diagnostics) && diagnostics.len() == 2, "{diagnostics:?}");
}
