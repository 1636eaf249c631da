//! Tests of the `breaking` rules, with the rules' examples and with real edits to PX4 messages.
//!
//! `fixtures/breaking/<rule>.txt` contains the expected findings for a rule's examples. Each folder
//! `fixtures/breaking/<case>/` contains another case: definitions in `old/` and `new/`, and all expected findings in
//! `expected.txt`. To accept intended changes: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-codegen breaking::`.

use crate::support;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use uavspec_codegen::breaking::{Between, RULES, Rule, breaking};
use uavspec_codegen::diagnostic::{Level, Problem, has_errors};
use uavspec_codegen::finding::Finding;
use uavspec_codegen::internal::{Example, packages};
use uavspec_codegen::lint;
use uavspec_codegen::schema::Schema;
use uavspec_codegen::{SourceMap, read, render};

use support::{differs, files_below, shared};

/// Displayed paths of files, and their text.
type Files = Vec<(String, String)>;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/breaking")
}

fn schema_of(sources: &mut SourceMap, side: &str, files: &Files) -> Schema {
    let files = files.iter().map(|(path, text)| (path.as_str(), text.as_str()));
    let packages = packages(files, side, sources);
    let (schema, diagnostics) = read(sources, &packages);
    assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, sources, false));
    schema
}

fn compare(old: &Files, new: &Files, between: Between) -> (SourceMap, Vec<Finding>) {
    let mut sources = SourceMap::default();
    let before = schema_of(&mut sources, "old", old);
    let after = schema_of(&mut sources, "new", new);
    let findings = breaking(&sources, &before, &after, between);
    (sources, findings)
}

fn files_of(examples: &[Example]) -> Files {
    examples.iter().map(|example| (example.path.to_owned(), example.text.to_owned())).collect()
}

fn files_in(folder: &Path) -> Files {
    let files = files_below(folder, &["msg", "srv", "action", "md"]);
    let shown = |file: &PathBuf| {
        let path =
            file.strip_prefix(folder).expect("a file in the folder").to_string_lossy().replace('\\', "/");
        (path, fs::read_to_string(file).expect("a text"))
    };
    files.iter().map(shown).collect()
}

fn check_examples(rule: &Rule) -> Vec<String> {
    let (old, new) = (files_of(rule.old), files_of(rule.new));
    let (sources, mut findings) = compare(&old, &new, Between::Commits);
    findings.retain(|finding| finding.rule == rule.id);
    let mut failures = Vec::new();
    let declared: BTreeSet<(&str, Level)> =
        rule.breaks.iter().map(|(category, level)| (category.name(), *level)).collect();
    let found: BTreeSet<(&str, Level)> =
        findings.iter().filter_map(|finding| Some((finding.category?, finding.level))).collect();
    if found != declared {
        failures.push(format!("{}: found {found:?}, but the rule declares {declared:?}", rule.id));
    }
    let text = render::findings(&findings, &sources, false);
    failures.extend(differs(&fixtures().join(format!("{}.txt", rule.id)), &text));
    for files in [&old, &new] {
        let (sources, findings) = compare(files, files, Between::Commits);
        if !findings.is_empty() {
            failures.push(format!("{}: {}", rule.id, render::findings(&findings, &sources, false)));
        }
    }
    failures
}

#[test]
fn each_rule_finds_its_example_in_the_declared_categories() {
    let failures: Vec<String> = RULES.iter().flat_map(|rule| check_examples(rule)).collect();
    assert!(
        failures.is_empty(),
        "{}\nUAVSPEC_UPDATE_FIXTURES=1 accepts the current findings",
        failures.join("\n")
    );
}

#[test]
fn each_further_case_has_the_expected_findings() {
    let mut failures = Vec::new();
    for entry in fs::read_dir(fixtures()).expect("fixtures") {
        let folder = entry.expect("an entry").path();
        if !folder.is_dir() {
            let name = folder.file_stem().expect("a name").to_string_lossy().into_owned();
            assert!(RULES.iter().any(|rule| rule.id == name), "{name} is not a rule");
            continue;
        }
        let between = if folder.join("releases").is_file() { Between::Releases } else { Between::Commits };
        let (sources, findings) =
            compare(&files_in(&folder.join("old")), &files_in(&folder.join("new")), between);
        failures.extend(differs(&folder.join("expected.txt"), &render::findings(&findings, &sources, false)));
    }
    assert!(
        failures.is_empty(),
        "{}\nUAVSPEC_UPDATE_FIXTURES=1 accepts the current findings",
        failures.join("\n")
    );
}

/// The names that findings of these rules put in backticks. `Message.field` is shortened to `field`.
fn named(findings: &[Finding], rules: &[&str]) -> BTreeSet<String> {
    let of_rules = findings.iter().filter(|finding| rules.contains(&finding.rule));
    let words =
        of_rules.flat_map(|finding| finding.message.split('`').map(str::to_owned).collect::<Vec<_>>());
    words.map(|word| word.rsplit('.').next().unwrap_or_default().to_owned()).collect()
}

fn strings(value: &Value) -> BTreeSet<String> {
    let list = value.as_array().expect("a list");
    list.iter().map(|item| item.as_str().expect("a string").to_owned()).collect()
}

/// The differences between the actual findings for a real edit and the expected findings in `expect.json`.
fn check_edit(folder: &Path) -> Vec<String> {
    let expected: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("expect.json")).expect("a text")).expect("JSON");
    let (old, new) = (files_in(&folder.join("old")), files_in(&folder.join("new")));
    let (_, findings) = compare(&old, &new, Between::Commits);
    let has = |wanted: &dyn Fn(&Finding) -> bool| findings.iter().any(wanted);
    let mut failures = Vec::new();
    let mut expect = |what: &str, found: bool, expected: bool| {
        if found != expected {
            failures.push(format!("{}: {what}: expected {expected}, found {found}", folder.display()));
        }
    };
    let is_layout = |finding: &Finding| matches!(finding.category, Some("json" | "cdr" | "uorb"));
    let fields_changed = expected["fields_changed"] == true;
    expect("changed fields", has(&is_layout), fields_changed);
    let is_missing = |finding: &Finding| finding.rule == "message-version";
    expect("missing version change", has(&is_missing), expected["version_bump_missing"] == true);
    let is_needless = |finding: &Finding| finding.rule == "message-version-needless";
    expect("needless version change", has(&is_needless), expected["version_bump_needless"] == true);
    let changed = strings(&expected["constants_changed"]);
    let found = named(&findings, &["constant-value-changed", "queue-length-changed"]);
    expect("renumbered constants", changed.is_subset(&found), true);
    let removed = strings(&expected["constants_removed"]);
    let found = named(&findings, &["constant-removed", "constant-renamed", "constant-reused"]);
    expect("removed constants", removed.is_subset(&found), true);
    if !fields_changed && changed.is_empty() && removed.is_empty() {
        expect("a warning or error", has(&|finding| finding.level > Level::Note), false);
    }
    failures
}

#[test]
fn real_edits_have_the_expected_findings() {
    let Some(corpus) = shared("corpus/breaking") else { return };
    let edits: Vec<PathBuf> =
        fs::read_dir(corpus).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    assert!(!edits.is_empty());
    let failures: Vec<String> = edits.iter().flat_map(|folder| check_edit(folder)).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Compares two sets in both directions. An item reported as added in one direction must be reported as removed in the
/// other. All other changes must be found in both directions.
fn check_reverse(old: &Files, new: &Files) {
    let (_, forth) = compare(old, new, Between::Releases);
    let (_, back) = compare(new, old, Between::Releases);
    let count = |findings: &[Finding], rule: &str| findings.iter().filter(|found| found.rule == rule).count();
    let pairs = [("field-added", "field-removed"), ("topic-added", "topic-removed")];
    let same = [
        "array-length-changed",
        "field-renamed",
        "field-type-changed",
        "field-unit-changed",
        "constant-value-changed",
        "queue-length-changed",
    ];
    for (one, other) in pairs.into_iter().chain(same.map(|rule| (rule, rule))) {
        assert_eq!(count(&forth, one), count(&back, other), "{one} and {other}");
        assert_eq!(count(&forth, other), count(&back, one), "{one} and {other}");
    }
    for files in [old, new] {
        let (sources, findings) = compare(files, files, Between::Commits);
        assert!(findings.is_empty(), "{}", render::findings(&findings, &sources, false));
    }
}

#[test]
fn comparing_releases_in_reverse_finds_the_reverse_changes() {
    let Some(corpus) = shared("corpus/px4") else { return };
    let releases = ["1.15", "1.16", "main"].map(|release| files_in(&corpus.join(release).join("msg")));
    check_reverse(&releases[0], &releases[1]);
    check_reverse(&releases[1], &releases[2]);
    check_reverse(&releases[0], &releases[2]);
}

#[test]
fn rule_ids_are_unique() {
    let mut ids: Vec<&str> = RULES.iter().map(|rule| rule.id).collect();
    ids.extend(lint::RULES.iter().map(|rule| rule.id));
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    for rule in RULES {
        assert!(!Problem::CODES.contains(&rule.id), "{} is also the id of a parser diagnostic", rule.id);
    }
}
