//! Tests of the `breaking` rules, with the rules' examples and with real edits to PX4 messages.
//!
//! `fixtures/breaking/<rule>.txt` contains the expected findings for a rule's examples. Each folder
//! `fixtures/breaking/<case>/` contains another case: definitions in `old/` and `new/`, and all expected findings in
//! `expected.txt`. To accept intended changes: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-lint breaking::`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use support::{differs, extent, files_below, shared};
use uavspec_dynamic::breaking::{Between, RULES, Rule, breaking};
use uavspec_schema::diagnostic::{Level, Problem, has_errors};
use uavspec_schema::example::{Example, packages};
use uavspec_schema::finding::Finding;
use uavspec_schema::{Schema, SourceMap, read, render};
use uavspec_test_definitions as support;

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

/// Definitions as path and text.
type Texts<'t> = &'t [(&'t str, &'t str)];

/// The rules and categories of the findings between two sets of definitions.
fn found(old: Texts<'_>, new: Texts<'_>) -> BTreeSet<(&'static str, &'static str)> {
    let files = |texts: Texts<'_>| -> Files {
        texts.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect()
    };
    let (_, findings) = compare(&files(old), &files(new), Between::Commits);
    findings.iter().map(|finding| (finding.rule, finding.category.unwrap_or_default())).collect()
}

/// The rules of the findings between two sets of ROS 2 packages. All packages except `glider_msgs` are dependencies.
fn with_dependencies(old: Texts<'_>, new: Texts<'_>) -> BTreeSet<&'static str> {
    let mut sources = SourceMap::default();
    let mut read_side = |side: &str, files: Texts<'_>| {
        let mut packages = packages(files.iter().copied(), side, &mut sources);
        for package in packages.iter_mut().filter(|package| package.name != "glider_msgs") {
            package.select = Some(Vec::new());
        }
        let (schema, diagnostics) = read(&sources, &packages);
        assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
        schema
    };
    let (before, after) = (read_side("old", old), read_side("new", new));
    breaking(&sources, &before, &after, Between::Commits).iter().map(|finding| finding.rule).collect()
}

#[test]
fn ignores_which_messages_of_dependencies_are_used() {
    const FIELDS: &str = "float32 speed\nfloat32 course\nfloat32 gust\nfloat32 age\n";
    let glider = ("glider_msgs/Glider.msg", "wind_msgs/Wind wind\n");
    let wind = ("wind_msgs/Wind.msg", FIELDS);
    let rain = ("wind_msgs/Rain.msg", "float32 rate\n");
    let both = [("glider_msgs/Glider.msg", "wind_msgs/Wind wind\nwind_msgs/Rain rain\n"), wind, rain];
    let one = [glider, wind, rain];
    assert_eq!(with_dependencies(&both, &one), BTreeSet::from(["field-removed"]));
    assert_eq!(with_dependencies(&one, &both), BTreeSet::from(["field-added"]));
    // Another dependency with the same fields isn't the renamed dependency.
    let other = [("glider_msgs/Glider.msg", "breeze_msgs/Breeze wind\n"), ("breeze_msgs/Breeze.msg", FIELDS)];
    assert_eq!(with_dependencies(&one, &other), BTreeSet::from(["field-type-changed"]));
    // A change inside a dependency is still found.
    let changed = ("wind_msgs/Wind.msg", "float64 speed\nfloat32 course\nfloat32 gust\nfloat32 age\n");
    let expected = BTreeSet::from(["field-type-changed", "nested-changed"]);
    assert_eq!(with_dependencies(&[glider, wind], &[glider, changed]), expected);
}

const FLAPS: &str = "uint64 timestamp\nfloat32 left\nfloat32 right\n";

/// A message with this version that contains a `Flaps` message with these fields.
fn nested(version: u32, flaps: &str) -> Files {
    let glider = format!("uint32 MESSAGE_VERSION = {version}\nuint64 timestamp\nFlaps flaps\n");
    vec![("Glider.msg".to_owned(), glider), ("Flaps.msg".to_owned(), flaps.to_owned())]
}

/// The rules and categories of the findings about `Glider` if the fields of its nested message change.
fn of_glider(version: u32, flaps: &str) -> BTreeSet<(&'static str, &'static str)> {
    let (_, findings) = compare(&nested(0, FLAPS), &nested(version, flaps), Between::Commits);
    let findings = findings.iter().filter(|finding| finding.message.contains("`Glider"));
    findings.map(|finding| (finding.rule, finding.category.unwrap_or_default())).collect()
}

#[test]
fn a_nested_change_is_a_reason_for_a_new_version() {
    let added = format!("{FLAPS}float32 middle\n");
    let layout = [("nested-changed", "cdr"), ("nested-changed", "uorb")];
    let silent = [layout[0], layout[1], ("nested-changed", "version")];
    assert_eq!(of_glider(0, &added), BTreeSet::from(silent));
    assert_eq!(of_glider(1, &added), BTreeSet::from(layout));
    let jump = [layout[0], layout[1], ("message-version", "version")];
    assert_eq!(of_glider(2, &added), BTreeSet::from(jump));
    assert_eq!(of_glider(1, FLAPS), BTreeSet::from([("message-version-needless", "version")]));
}

#[test]
fn nested_fields_that_swap_places_change_the_outer_message() {
    let swapped = "uint64 timestamp\nfloat32 right\nfloat32 left\n";
    let layout = [("nested-changed", "cdr"), ("nested-changed", "uorb")];
    assert_eq!(of_glider(1, swapped), BTreeSet::from(layout));
    // A renamed field has the same bytes, but PX4's hash changes.
    let renamed = "uint64 timestamp\nfloat32 left_angle\nfloat32 right\n";
    assert_eq!(of_glider(1, renamed), BTreeSet::new());
}

#[test]
fn only_px4_messages_break_uorb() {
    let fields = "float32 speed\nfloat32 course\nfloat32 gust\nfloat32 age\n";
    let removed = ["source", "json", "cdr"];
    let found = found(&[("wind_msgs/Wind.msg", fields)], &[("wind_msgs/Breeze.msg", fields)]);
    assert_eq!(found, BTreeSet::from(removed.map(|category| ("message-renamed", category))));
    let found = self::found(
        &[("wind_msgs/Wind.msg", fields), ("wind_msgs/Rain.msg", "float32 rate\n")],
        &[("wind_msgs/Wind.msg", fields)],
    );
    assert_eq!(found, BTreeSet::from(removed.map(|category| ("message-removed", category))));
}

#[test]
fn the_char_of_ros_2_is_an_uint8() {
    let glider = ("glider_msgs/Glider.msg", "Flap flap\n");
    let old = [glider, ("glider_msgs/Flap.msg", "char KIND_PLAIN = 1\nchar kind\nchar[4] name\n")];
    let new = [glider, ("glider_msgs/Flap.msg", "uint8 KIND_PLAIN = 1\nuint8 kind\nuint8[4] name\n")];
    assert_eq!(found(&old, &new), BTreeSet::new());
    let found = found(&[("Flap.msg", "char[4] name\n")], &[("Flap.msg", "uint8[4] name\n")]);
    assert!(found.contains(&("field-type-changed", "source")), "{found:?}");
}

#[test]
fn a_bound_in_another_notation_is_the_same() {
    let old = [("Wind.msg", "float32 speed  # [m/s] [@range 0, 1] Speed\n")];
    let new = [("Wind.msg", "float32 speed  # [m/s] [@range 0.0, 1.0] Speed\n")];
    assert_eq!(found(&old, &new), BTreeSet::new());
}

#[test]
fn only_fields_at_the_end_leave_other_fields_in_place() {
    let short = "uint64 timestamp\nfloat32 sink\n";
    let long = "uint64 timestamp\nuint8 mode\nfloat32 sink\nbool landed\nbool towed\n";
    let files = |text: &str| vec![("Glider.msg".to_owned(), text.to_owned())];
    let at_end = |old: &str, new: &str| -> Vec<bool> {
        let (_, findings) = compare(&files(old), &files(new), Between::Commits);
        let fields = findings.iter().filter(|finding| finding.rule.starts_with("field-"));
        let cdr = fields.filter(|finding| finding.category == Some("cdr"));
        cdr.map(|finding| finding.help.starts_with("messages are ")).collect()
    };
    assert_eq!(at_end(short, long), [false, true, true]);
    assert_eq!(at_end(long, short), [false, true, true]);
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
    let mut sources = SourceMap::default();
    let sides = [("old", old), ("new", new)];
    let [before, after] = sides.map(|(side, files)| schema_of(&mut sources, side, files));
    let forth = breaking(&sources, &before, &after, Between::Releases);
    let back = breaking(&sources, &after, &before, Between::Releases);
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
    for (schema, (side, files)) in [before, after].iter().zip(sides) {
        let again = schema_of(&mut sources, &format!("again {side}"), files);
        let findings = breaking(&sources, schema, &again, Between::Commits);
        assert!(findings.is_empty(), "{}", render::findings(&findings, &sources, false));
    }
}

#[test]
fn comparing_releases_in_reverse_finds_the_reverse_changes() {
    let Some(corpus) = shared("corpus/px4") else { return };
    let releases = ["1.15", "1.16", "main"].map(|release| files_in(&corpus.join(release).join("msg")));
    for (old, new) in extent::<&[(usize, usize)]>(&[(0, 1), (1, 2), (0, 2)], &[(0, 2)]) {
        check_reverse(&releases[*old], &releases[*new]);
    }
}

#[test]
fn rule_ids_are_unique() {
    let mut ids: Vec<&str> = RULES.iter().map(|rule| rule.id).collect();
    ids.extend(uavspec_lint::RULES.iter().map(|rule| rule.id));
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    for rule in RULES {
        assert!(
            Problem::KINDS.iter().all(|kind| kind.code != rule.id),
            "{} is also the id of a parser diagnostic",
            rule.id
        );
    }
}
