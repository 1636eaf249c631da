//! Fixtures for diagnostics. Each folder contains definitions, and all expected diagnostics in `expected.txt`.
//!
//! A case in `err/<code>` causes at least the error `<code>`. A case in `warn/<code>` causes at least the warning
//! `<code>`, and no error; it covers more than the example of the lint rule with this id. A case in `ok/<name>` causes
//! no diagnostics. A folder `<code>-<case>` is an additional case for `<code>`.
//!
//! Markdown, `AsciiDoc` and text files are pages, `.json` files are event metadata, and `.po` files are translation
//! catalogues. Other files are PX4 definitions, unless a `dialect` file contains `ros2`. With `ros2`, the files are ROS
//! 2 definitions, and each subfolder is a package.
//!
//! To update: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-schema fixtures::`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use support::{differs, extent, files_below, package};
use uavspec_schema::diagnostic::{Level, Problem, ProblemKind, has_errors};
use uavspec_schema::example::is_catalogue;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::{Diagnostic, Form, PackageInput, SourceMap, read, render, translation};
use uavspec_test_definitions as support;

const FILES: [&str; 8] = ["msg", "srv", "action", "md", "adoc", "txt", "json", "po"];

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// The sorted names of the cases in the folder `kind`.
fn cases(kind: &str) -> Vec<String> {
    let entries = fs::read_dir(fixtures().join(kind)).expect("fixtures");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The code in the name of a folder: the longest matching code, because one code may be a prefix of another.
fn code_of(case: &str) -> Option<&'static str> {
    let starts =
        |code: &&str| case.strip_prefix(*code).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'));
    Problem::KINDS.iter().map(|kind| kind.code).filter(starts).max_by_key(|code| code.len())
}

fn read_case(folder: &Path) -> (SourceMap, Vec<Diagnostic>) {
    let is_ros2 = match fs::read_to_string(folder.join("dialect")).as_deref().map(str::trim) {
        Ok("ros2") => true,
        Ok(other) => panic!("{}: unknown dialect {other:?}", folder.display()),
        Err(_) => false,
    };
    let mut sources = SourceMap::default();
    let mut packages: BTreeMap<String, PackageInput> = BTreeMap::new();
    let mut catalogues = Vec::new();
    let mut diagnostics = Vec::new();
    for file in files_below(folder, &FILES).iter().filter(|file| !file.ends_with("expected.txt")) {
        let path =
            file.strip_prefix(folder).expect("a file of the folder").to_string_lossy().replace('\\', "/");
        let is_message = Kind::of(&path).is_some();
        let (name, form) = match path.split_once('/') {
            _ if file.extension().is_some_and(|extension| extension == "json") => ("events", Form::Events),
            _ if !is_message => ("pages", Form::Table),
            Some((folder, _)) if is_ros2 => (folder, Form::Msg(Dialect::Ros2)),
            None if is_ros2 => ("demo", Form::Msg(Dialect::Ros2)),
            _ => ("demo", Form::Msg(Dialect::Px4)),
        };
        match sources.add(path.as_str(), fs::read(file).expect("a readable file")) {
            Ok(id) if is_catalogue(&path) => catalogues.push(id),
            Ok(id) => packages.entry(name.to_owned()).or_insert_with(|| package(name, form)).sources.push(id),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let packages: Vec<PackageInput> = packages.into_values().collect();
    let (schema, mut found) = read(&sources, &packages);
    diagnostics.append(&mut found);
    if !has_errors(&diagnostics) {
        diagnostics.append(&mut translation::resolve(&sources, &schema, &catalogues).1);
    }
    (sources, diagnostics)
}

/// Checks a case, and returns the failure.
fn check(kind: &str, case: &str) -> Option<String> {
    let folder = fixtures().join(kind).join(case);
    let (sources, diagnostics) = read_case(&folder);
    let found = render::render(&diagnostics, &sources, false);
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.level() == Level::Error).count();
    let has = |level| {
        let mut of_level = diagnostics.iter().filter(|diagnostic| diagnostic.level() == level);
        of_level.any(|diagnostic| code_of(case) == Some(diagnostic.problem.code()))
    };
    let matches_name = match kind {
        "err" => has(Level::Error),
        "warn" => has(Level::Warning) && errors == 0,
        _ => found.is_empty(),
    };
    if !matches_name {
        return Some(format!("{kind}/{case} does not match its name:\n{found}"));
    }
    differs(&folder.join("expected.txt"), &found)
}

#[test]
fn each_fixture_has_the_expected_diagnostics() {
    let mut failures = String::new();
    for kind in ["ok", "err", "warn"] {
        for failure in cases(kind).iter().filter_map(|case| check(kind, case)) {
            writeln!(failures, "{failure}").expect("a string");
        }
    }
    assert!(failures.is_empty(), "{failures}update with UAVSPEC_UPDATE_FIXTURES=1");
}

/// A diagnostic code, and the paths and contents of the files that cause the diagnostic.
type Generated = (&'static str, Vec<(String, Vec<u8>)>);

/// Definitions that are too large for fixtures, with the diagnostic codes that they cause.
fn generated() -> [Generated; 5] {
    let spaces = ("Glider.msg".to_owned(), vec![b' '; (4 << 20) + 1]);
    // Each level has 32 fields of the previous level's type, so the last level contains more than 2^20 fields.
    let levels = (0..5).map(|level: u32| {
        let ty = level.checked_sub(1).map_or("bool".to_owned(), |below| format!("Level{below}"));
        let fields: String = (0..32).map(|field| format!("{ty} part{field}\n")).collect();
        (format!("Level{level}.msg"), fields.into_bytes())
    });
    // Each link contains all previous links: 3000 * 3001 / 2 fields in total. In a quick run, only the depth exceeds its
    // limit.
    let chain = (0..extent(3000, 1100)).map(|link: u32| {
        let ty = link.checked_sub(1).map_or("bool".to_owned(), |below| format!("Link{below}"));
        (format!("Link{link}.msg"), format!("{ty} part\n").into_bytes())
    });
    // Each field has a separate enum with all constants.
    let constants: String = (0..1100).map(|number| format!("uint16 MODE_{number}={number}\n")).collect();
    let fields: String =
        (0..1000).map(|number| format!("uint16 mode{number}  # [@enum MODE M{number}]\n")).collect();
    let enums = ("Glider.msg".to_owned(), (constants + &fields).into_bytes());
    [
        ("source-too-long", vec![spaces]),
        ("too-many-fields", levels.collect()),
        ("too-much-nesting", chain.collect()),
        ("too-many-members", vec![enums]),
        ("too-many-event-values", vec![("events.json".to_owned(), vec![b','; 1 << 17])]),
    ]
}

#[test]
fn rejects_definitions_too_large_for_fixtures() {
    // In a quick run, skip the limit on members, because reaching it takes seconds.
    let is_tried = |(code, _): &Generated| extent(true, *code != "too-many-members");
    for (code, files) in generated().into_iter().filter(is_tried) {
        let mut sources = SourceMap::default();
        let is_json = files.iter().any(|(path, _)| path == "events.json");
        let mut package = package("demo", if is_json { Form::Events } else { Form::Msg(Dialect::Px4) });
        let mut diagnostics = Vec::new();
        for (path, bytes) in files {
            match sources.add(path, bytes) {
                Ok(id) => package.sources.push(id),
                Err(diagnostic) => diagnostics.push(diagnostic),
            }
        }
        diagnostics.append(&mut read(&sources, &[package]).1);
        assert!(diagnostics.iter().any(|diagnostic| diagnostic.problem.code() == code), "{diagnostics:?}");
    }
}

/// Warnings need no fixture, because the examples of the lint rules with the same ids cause them.
#[test]
fn every_error_has_a_fixture() {
    let named: Vec<&str> = cases("err").iter().filter_map(|case| code_of(case)).collect();
    let generated = generated().map(|(code, _)| code);
    for ProblemKind { code, .. } in Problem::KINDS.iter().filter(|kind| kind.level == Level::Error) {
        assert!(
            named.contains(code) != generated.contains(code),
            "{code} has neither a fixture nor a generated definition"
        );
    }
}
