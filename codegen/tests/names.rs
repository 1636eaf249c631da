//! Names of packages, definitions and root files. Whatever the name, no file is written outside the output folder, and
//! the output is valid on all systems.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::json;
use uavspec_codegen::generate;

use uavspec_test_definitions::extent;

/// Names that are paths, devices or keywords. `ROOT` is replaced with the absolute path of the test's folder.
const NAMES: &[&str] = &[
    "",
    ".",
    "..",
    "/",
    "ROOT",
    "ROOT/escaped",
    "../escaped",
    "../../escaped",
    "a/../../escaped",
    "a/b",
    "a\\b",
    "..\\escaped",
    "C:",
    "C:escaped",
    "~",
    "CON",
    "con",
    "Aux",
    "NUL.x",
    "COM1",
    "lpt9",
    "Wind",
    "wind",
    "WIND",
    "Mod",
    "mod",
    "lib",
    "Self",
    "Crate",
    "Super",
    "class",
    "Type",
    "README",
    "Index",
    "ErrorCode",
    "Labels",
    "Data",
    ".hidden",
    ".uavspec-manifest",
    ".uavspec-stage",
    "a b",
    "a.",
    "a ",
    "-a",
    "é",
    "a\n",
    "\u{202e}a",
    "Go",
    "Go_Request",
    "Srv",
    "Action",
    "Json",
    "rules",
    "book",
    "SUMMARY",
];

fn name() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => select(NAMES).prop_map(str::to_owned),
        2 => "[A-Z][A-Za-z0-9_]{0,6}",
        1 => "[a-zA-Z0-9_./\\\\: -]{0,10}",
        1 => any::<String>(),
    ]
}

/// All files and folders outside the output folder, with the content of the files.
fn outside(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries =
        walkdir::WalkDir::new(root).into_iter().filter_entry(|entry| !entry.path().ends_with("work/out"));
    let content = |entry: walkdir::DirEntry| {
        let path = entry.path().display().to_string();
        (path, fs::read(entry.path()).unwrap_or_default())
    };
    entries.map(|entry| content(entry.expect("an entry"))).collect()
}

/// The file name of a definition, or `None` if the file system doesn't accept it.
fn file_name(name: &str, extension: &str) -> Option<String> {
    let name = format!("{name}.{extension}");
    (name.len() < 200 && !name.contains(['/', '\0'])).then_some(name)
}

/// True if all systems accept the name of a file or folder.
fn is_portable(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    !["con", "prn", "aux", "nul", "com1", "lpt9"].contains(&stem.as_str()) && !name.ends_with(['.', ' '])
}

fn check(package: &str, root_file: &str, definitions: &[(String, &str)], heading: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let absolute = |name: &str| name.replace("ROOT", &folder.path().join("work").display().to_string());
    let work = folder.path().join("work");
    for below in ["msg", "pages", "out"] {
        fs::create_dir_all(work.join(below)).expect("a folder");
    }
    fs::write(work.join("msg/Plain.msg"), "uint64 timestamp # [us] Time\n").expect("a file");
    fs::write(folder.path().join("escaped"), "precious").expect("a file");
    for (name, extension) in definitions {
        let text =
            if *extension == "msg" { "uint64 timestamp # [us] Time\n" } else { "uint8 a\n---\nuint8 b\n" };
        let path = file_name(&absolute(name), extension).map(|name| work.join("msg").join(name));
        // Ignore errors, because some names are not valid file names on this system.
        let _ = path.map(|path| fs::write(path, text));
    }
    let page = format!("# Page\n\n## {}\n\ninteger, Text.\n", absolute(heading));
    fs::write(work.join("pages/page.md"), page).expect("a file");
    let config = format!(
        "[output]\nrust = {{ path = \"out/rust\", root = {} }}\njson_schema = \"out/schemas\"\n\
         vectors = \"out/vectors\"\ndocs = {{ path = \"out/docs\", rules = {} }}\ntypescript = \"out/ts\"\n\
         python = \"out/python\"\n\n[[package]]\nname = {}\ndialect = \"px4\"\ninclude = [\"msg/*\"]\n\n\
         [[package]]\nname = \"pages\"\ndialect = \"table\"\ninclude = [\"pages/*.md\"]\n",
        json!(absolute(root_file)),
        package == "rules",
        json!(absolute(package)),
    );
    fs::write(work.join("uavspec.toml"), config).expect("a file");
    let before = outside(folder.path());
    let result = generate(work.join("uavspec.toml"));
    assert_eq!(
        outside(folder.path()),
        before,
        "{package:?} {root_file:?} {definitions:?} {heading:?}: {result:?}"
    );
    let mut written = BTreeSet::new();
    for entry in walkdir::WalkDir::new(work.join("out")).min_depth(1) {
        let entry = entry.expect("an entry");
        let name = entry.file_name().to_str().expect("UTF-8");
        assert!(result.is_ok() && is_portable(name), "{name} was written: {result:?}");
        assert!(written.insert(entry.path().display().to_string().to_lowercase()), "{name} is written twice");
    }
    assert!(result.is_err() || !written.is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn no_name_leaves_the_output_folder(
        package in prop_oneof![Just("demo".to_owned()), name()],
        root in prop_oneof![2 => Just("mod.rs".to_owned()), 1 => name().prop_map(|name| name + ".rs"), 1 => name()],
        definitions in vec((name(), select(&["msg", "srv"][..])), 0..3),
        heading in prop_oneof![Just("Plain".to_owned()), name()],
    ) {
        check(&package, &root, &definitions, &heading);
    }
}

#[test]
fn no_hostile_name_leaves_the_output_folder() {
    for (number, name) in NAMES.iter().enumerate() {
        // A quick run uses every other name, in one of the three places.
        let is_used = |place: usize| extent(true, number % 6 == 2 * place);
        if is_used(0) {
            check(name, "mod.rs", &[], "Plain");
        }
        if is_used(1) {
            check("demo", name, &[], "Plain");
        }
        if is_used(2) {
            check("demo", "mod.rs", &[((*name).to_owned(), "msg"), ((*name).to_owned(), "srv")], name);
        }
    }
}

/// The error for a configuration with these packages, or `None` if there is none.
fn error_of(packages: &[&str], definitions: &[&str]) -> Option<String> {
    let folder = tempfile::tempdir().expect("a folder");
    for name in definitions {
        fs::write(folder.path().join(name), "uint64 timestamp # [us] Time\n").expect("a file");
    }
    let package = |name: &&str| {
        format!("[[package]]\nname = {}\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n", json!(name))
    };
    let config = packages.iter().map(package).collect::<String>() + "[output]\njson_schema = \"out\"\n";
    let path = folder.path().join("uavspec.toml");
    fs::write(&path, config).expect("a file");
    generate(&path).err().map(|failure| failure.to_string())
}

#[test]
fn an_invalid_package_name_is_an_error_at_its_location() {
    for (name, wanted) in [
        ("", "the name of a package is empty"),
        ("..", "`..` is not a valid package name"),
        ("/tmp", "`/tmp` is not a valid package name"),
        ("my-msgs", "`my-msgs` is not a valid package name"),
        ("a\n", "`a\\n` is not a valid package name"),
        ("aux", "the package name `aux` is reserved on Windows"),
    ] {
        let error = error_of(&[name], &["Wind.msg"]).expect(name);
        assert!(
            error.contains(wanted) && error.contains("uavspec.toml:2:8") && error.contains("help: "),
            "{error}"
        );
    }
}

#[test]
fn two_packages_never_share_a_name() {
    let error = error_of(&["demo", "demo"], &["Wind.msg"]).expect("an error");
    assert!(error.contains("two packages are named `demo`") && error.contains("uavspec.toml:6:8"), "{error}");
    let error = error_of(&["demo", "Demo"], &["Wind.msg"]).expect("an error");
    assert!(error.contains("the package names `demo` and `Demo` differ in case only"), "{error}");
    assert_eq!(error_of(&["demo", "demo2"], &["Wind.msg"]), None);
}

#[test]
fn a_device_name_is_an_error_at_its_definition() {
    for name in ["CON", "Aux", "nul", "Com1"] {
        let error = error_of(&["demo"], &["Wind.msg", &format!("{name}.msg")]).expect(name);
        let wanted = format!("the name `{name}` is reserved on Windows");
        assert!(error.contains(&wanted) && error.contains(&format!("{name}.msg:1:1")), "{error}");
        assert!(error.contains("help: rename it"), "{error}");
    }
    assert_eq!(error_of(&["demo"], &["Control.msg", "Auxiliary.msg", "Mod.msg"]), None);
}
