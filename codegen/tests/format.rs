//! The layout of definitions and pages: it says the same as before, in the way that the fixtures show, and
//! a second run finds nothing to do.
//!
//! One folder in `fixtures/format` a case: `in.*`, and `out.*` as it should be laid out; a file `dialect`
//! says `ros2` where it isn't px4. After a change that is meant: `UAVSPEC_UPDATE_FIXTURES=1 cargo test --test format`.

mod support;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::Value as Json;
use uavspec_codegen::diagnostic::{Level, has_errors, render};
use uavspec_codegen::emit::inspect;
use uavspec_codegen::format::{Formatted, format};
use uavspec_codegen::msg::annotation::Note;
use uavspec_codegen::msg::{self, Dialect, Kind};
use uavspec_codegen::schema::Form;
use uavspec_codegen::{Diagnostic, PackageInput, SourceMap, read, table};

use support::{files_below, shared};

/// The layout of one file, or what is wrong with it.
fn laid_out(path: &str, text: &str, form: Form) -> Result<Formatted, Vec<Diagnostic>> {
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).map_err(|diagnostic| vec![diagnostic])?;
    format(&sources, id, form)
}

/// The model of files, and the codes of errors in them.
fn model(form: Form, files: &[(String, String)]) -> (Json, Vec<&'static str>) {
    let mut sources = SourceMap::default();
    let mut package = support::package("demo", form);
    for (path, text) in files {
        package.sources.extend(sources.add(path.as_str(), text.as_bytes().to_vec()));
    }
    let (schema, diagnostics) = read(&sources, &[package]);
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.level() == Level::Error);
    let mut errors: Vec<&str> = errors.map(|diagnostic| diagnostic.problem.code()).collect();
    errors.sort_unstable();
    (inspect::schema(&schema), errors)
}

/// Every comment: its text, the number of its annotations, and its parameters.
fn comments(path: &str, text: &str, dialect: Dialect) -> Vec<String> {
    fn words(note: &Note<'_>) -> String {
        let parameters: Vec<String> = note.parameters.iter().map(words).collect();
        format!("{} {} {parameters:?}", note.annotations.len(), note.text)
    }
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).expect("a text");
    let kind = Kind::of(path).expect("a definition");
    let (definition, _) = msg::parse(&sources, id, kind, dialect);
    let lines = definition.parts.iter().flat_map(|part| &part.lines);
    let comments = lines.filter_map(|line| line.comment.as_deref());
    comments.map(|found| found.note.as_ref().map_or_else(|| found.text.trim().to_owned(), words)).collect()
}

/// All cells of a page.
fn cells(path: &str, text: &str) -> Vec<Vec<String>> {
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).expect("a text");
    let (page, _) = table::parse(&sources, id);
    let rows =
        page.tables.iter().flat_map(|table| table.rows.iter().map(|row| &row.cells).chain([&table.header]));
    rows.map(|row| row.iter().map(|cell| cell.text.as_str().to_owned()).collect()).collect()
}

/// What is wrong with the layout of a file; nothing, if all is as it should be. A file with mistakes has none.
fn check_layout(path: &str, text: &str, form: Form) -> Result<Option<String>, String> {
    let Ok(first) = laid_out(path, text, form) else { return Ok(None) };
    let problem = |what: &str| Err(format!("{path}: {what}\n{text:?}\n{:?}", first.text));
    if first.is_kept {
        return problem("the layout says something else");
    }
    match laid_out(path, &first.text, form) {
        Ok(second) if second.text == first.text && !second.is_kept => {}
        Ok(second) => return problem(&format!("a second run gives another layout: {:?}", second.text)),
        Err(diagnostics) => return problem(&format!("the layout is a mistake: {diagnostics:?}")),
    }
    let is_same = match form {
        Form::Msg(dialect) => comments(path, text, dialect) == comments(path, &first.text, dialect),
        Form::Table => cells(path, text) == cells(path, &first.text),
    };
    if !is_same {
        return problem("not every comment or cell is kept");
    }
    let is_tidy = |line: &str| !line.ends_with([' ', '\t', '\r']);
    if let (Form::Msg(_), Some(line)) = (form, first.text.split('\n').find(|line| !is_tidy(line))) {
        return problem(&format!("white space at the end of {line:?}"));
    }
    if !first.text.is_empty() && (!first.text.ends_with('\n') || first.text.ends_with("\n\n")) {
        return problem("the end is no single end of a line");
    }
    Ok(Some(first.text))
}

/// Lays out files of one package, and compares their model with that of the layout.
fn check_files(form: Form, files: &[(String, String)]) -> Result<usize, String> {
    let mut laid_out = files.to_vec();
    let mut count = 0;
    for (path, text) in &mut laid_out {
        if let Some(new) = check_layout(path, text, form)? {
            *text = new;
            count += 1;
        }
    }
    let [before, after] = [files, &laid_out].map(|files| model(form, files));
    if before == after { Ok(count) } else { Err(format!("another model: {files:?}\n{laid_out:?}")) }
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/format")
}

/// What is wrong with a case; nothing, if all is as it should be.
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
    Some(format!("{} is laid out as\n{found}and not as\n{expected}", folder.display()))
}

#[test]
fn each_fixture_is_laid_out_as_expected() {
    let mut failures = String::new();
    let mut folders: Vec<PathBuf> =
        fs::read_dir(fixtures()).expect("fixtures").map(|entry| entry.expect("an entry").path()).collect();
    folders.sort();
    for failure in folders.iter().filter_map(|folder| check_fixture(folder)) {
        writeln!(failures, "{failure}").expect("a string");
    }
    assert!(failures.is_empty(), "{failures}UAVSPEC_UPDATE_FIXTURES=1 takes this layout for expected");
}

fn texts(files: Vec<PathBuf>) -> Vec<(String, String)> {
    let text = |path: PathBuf| {
        fs::read_to_string(&path).ok().map(|text| (path.to_string_lossy().into_owned(), text))
    };
    files.into_iter().filter_map(text).collect()
}

/// Every folder of the corpus that is a package, and how it is written.
fn packages(corpus: &Path) -> Vec<(PathBuf, Dialect)> {
    let below = |path: &str, dialect| {
        let entries = fs::read_dir(corpus.join(path)).expect("a folder of the corpus");
        let folders = entries.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir());
        folders.map(|folder| (folder, dialect)).collect::<Vec<_>>()
    };
    let changes = below("breaking", Dialect::Px4).into_iter();
    let changes = changes.flat_map(|(folder, dialect)| ["old", "new"].map(|at| (folder.join(at), dialect)));
    let mut packages: Vec<_> = changes.collect();
    packages.extend(below("px4", Dialect::Px4));
    packages.extend(below("ros2", Dialect::Ros2));
    packages
}

#[test]
fn definitions_of_the_corpus_say_the_same_as_before() {
    let Some(corpus) = shared("corpus") else { return };
    let mut count = 0;
    for (folder, dialect) in packages(&corpus) {
        let files = texts(files_below(&folder, &["msg", "srv", "action"]));
        let laid_out = check_files(Form::Msg(dialect), &files).unwrap_or_else(|problem| panic!("{problem}"));
        count += laid_out;
    }
    assert!(count > 900, "{count} files");
}

#[test]
fn pages_of_the_specification_say_the_same_as_before() {
    let Some(folder) = shared("spec") else { return };
    for (path, text) in texts(files_below(&folder, &["md", "adoc", "txt"])) {
        check_files(Form::Table, &[(path, text)]).unwrap_or_else(|problem| panic!("{problem}"));
    }
}

#[test]
fn our_own_definitions_are_laid_out() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../definitions");
    for (sub, form) in [("px4", Form::Msg(Dialect::Px4)), ("flockwave", Form::Table)] {
        for (path, text) in texts(files_below(&folder.join(sub), &["msg", "md"])) {
            let found = laid_out(&path, &text, form).expect("no mistakes");
            assert!(found.text == text && !found.is_kept, "{path}: run `cargo xtask fmt`\n{}", found.text);
        }
    }
}

#[test]
fn mistakes_are_reported_all_at_once() {
    let diagnostics =
        laid_out("A.msg", "uint8 A = 300\nuint8[0] b\n", Form::Msg(Dialect::Px4)).expect_err("two mistakes");
    assert!(has_errors(&diagnostics) && diagnostics.len() == 2, "{diagnostics:?}");
}
