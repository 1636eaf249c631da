//! Tests of `breaking` against folders and Git revisions.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value as Json;
use support::{CONFIG, write, xtask};
use tempfile::TempDir;

use crate::support;

const WIND: &str =
    "# Wind over ground\n\nuint64 timestamp  # [us] Since start\nfloat32 speed     # [m/s] Speed\n";
const CALM: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start\n";

/// Runs the command, and returns the status, the standard output and the standard error.
fn breaking(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let arguments = [&["breaking"], arguments].concat();
    let Output { status, stdout, stderr } = xtask(folder, &arguments);
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

fn git(folder: &Path, arguments: &[&str]) {
    let identity =
        ["-c", "user.name=Tester", "-c", "user.email=tester@example.org", "-c", "commit.gpgsign=false"];
    let output = Command::new("git").arg("-C").arg(folder).args(identity).args(arguments).output();
    let output = output.expect("this test requires git");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A repository with a commit tagged `before`. In this commit, a message has one more field than in the working tree.
fn repository() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "definitions/uavspec.toml", CONFIG);
    write(folder.path(), "definitions/msg/Wind.msg", WIND);
    git(folder.path(), &["init", "--quiet", "--initial-branch", "main"]);
    git(folder.path(), &["add", "."]);
    git(folder.path(), &["commit", "--quiet", "--message", "Start"]);
    git(folder.path(), &["tag", "before"]);
    write(folder.path(), "definitions/msg/Wind.msg", CALM);
    folder
}

#[test]
fn compares_a_revision_with_the_working_tree() {
    let folder = repository();
    for (place, arguments) in [
        ("", &["--against", "before"][..]),
        ("definitions/msg", &["--against", "before"]),
        ("", &["--against", "HEAD", "--package", "demo", "--dialect", "px4", "--input", "definitions/msg"]),
        (
            "definitions",
            &["--against", "main", "--package", "demo", "--dialect", "px4", "--input", "msg/Wind.msg"],
        ),
    ] {
        let (status, results, _) = breaking(&folder.path().join(place), arguments);
        assert_eq!(status, Some(1), "{results}");
        assert!(results.contains("error[field-removed]: `Wind.speed` (float32) was removed"), "{results}");
        assert!(results.contains(&format!("--> {}:definitions/msg/Wind.msg:4:1", arguments[1])), "{results}");
        assert!(results.contains("1 change; incompatible: source 1, json 1, cdr 1, uorb 1"), "{results}");
    }
    write(folder.path(), "definitions/msg/Wind.msg", &WIND.replace("Speed", "How fast it blows"));
    let (status, results, _) = breaking(folder.path(), &["--against", "before"]);
    assert_eq!(status, Some(0), "{results}");
    assert!(results.contains("no relevant changes"), "{results}");
}

#[test]
fn uses_the_configuration_of_the_revision() {
    let folder = repository();
    fs::rename(folder.path().join("definitions/msg"), folder.path().join("definitions/messages"))
        .expect("a folder");
    write(folder.path(), "definitions/uavspec.toml", &CONFIG.replace("msg/*", "messages/*"));
    let (status, results, _) = breaking(folder.path(), &["--against", "before"]);
    assert_eq!(status, Some(1), "{results}");
    assert!(results.contains("`Wind.speed`"), "{results}");
}

#[test]
fn json_findings_have_both_locations() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "old/Wind.msg", WIND);
    write(folder.path(), "new/Wind.msg", &WIND.replace("float32", "float64"));
    let (status, printed, _) = breaking(
        folder.path(),
        &["--package", "demo", "--dialect", "px4", "--input", "new", "--against", "old", "--format", "json"],
    );
    assert_eq!(status, Some(1));
    let findings: Json = serde_json::from_str(&printed).expect("JSON");
    let findings = findings.as_array().expect("a list");
    let categories: Vec<&str> =
        findings.iter().map(|finding| finding["category"].as_str().expect("a category")).collect();
    assert_eq!(categories, ["source", "cdr", "uorb"], "JSON does not distinguish float widths");
    for finding in findings {
        assert_eq!(finding["rule"], "field-type-changed");
        assert_eq!(finding["level"], "error");
        assert_eq!(finding["message"], "`Wind.speed` has type float64 instead of float32");
        assert_eq!(
            (&finding["old"]["file"], &finding["new"]["file"]),
            (&"old/Wind.msg".into(), &"new/Wind.msg".into())
        );
        assert_eq!(finding["new"]["start"], serde_json::json!({ "line": 4, "column": 1 }));
        assert_eq!(finding["new"]["end"], serde_json::json!({ "line": 4, "column": 14 }));
    }
}

/// Checks that a command fails with status 2 and a hint.
#[track_caller]
fn fails(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let (status, _, errors) = breaking(folder, arguments);
    assert_eq!(status, Some(2), "{arguments:?}: {errors}");
    for part in parts {
        assert!(errors.contains(part), "{arguments:?}: {errors}");
    }
}

#[test]
fn failures_have_status_2_and_a_hint() {
    let folder = repository();
    let path = folder.path();
    fails(
        path,
        &["--against", "nowhere"],
        &["`nowhere` is not a folder or a revision", "help: give a folder or an existing branch"],
    );
    fails(path, &["--against=--upload-pack=x"], &["is not a folder or a revision"]);
    fs::create_dir(path.join("empty")).expect("a folder");
    fails(
        path,
        &["--against", "empty"],
        &["no definitions in empty", "help: definitions of the px4 dialect"],
    );
    write(path, "definitions/uavspec.toml", &format!("{CONFIG}dialekt = \"px4\"\n"));
    fails(
        path,
        &["--against", "before"],
        &["definitions/uavspec.toml:5:1", "unknown field `dialekt`", "help: the guide lists all keys"],
    );
    write(path, "definitions/uavspec.toml", CONFIG);
    write(path, "broken/uavspec.toml", CONFIG);
    write(path, "broken/msg/Wind.msg", "uint64\n");
    fails(path, &["--against", "broken"], &["the earlier definitions contain errors", "missing-name"]);

    let outside = tempfile::tempdir().expect("a temporary folder");
    write(outside.path(), "uavspec.toml", CONFIG);
    write(outside.path(), "msg/Wind.msg", WIND);
    fails(outside.path(), &["--against", "main"], &["is not in a Git repository", "help: give a folder"]);
}

#[test]
fn a_shallow_clone_causes_a_hint() {
    let folder = repository();
    git(folder.path(), &["commit", "--quiet", "--all", "--message", "Calm"]);
    let clone = tempfile::tempdir().expect("a temporary folder");
    let origin = format!("file://{}", folder.path().display());
    git(clone.path(), &["clone", "--quiet", "--depth", "1", "--no-tags", &origin, "copy"]);
    let hints = ["this clone is shallow", "git fetch --unshallow"];
    fails(&clone.path().join("copy"), &["--against", "before"], &hints);
    fails(&clone.path().join("copy"), &["--against", "HEAD~1"], &hints);
}

#[test]
fn errors_in_the_new_definitions_are_findings() {
    let folder = repository();
    write(folder.path(), "definitions/msg/Wind.msg", "uint64\nfoo bar\n");
    let (status, printed, _) = breaking(folder.path(), &["--against", "before", "--format", "json"]);
    assert_eq!(status, Some(1));
    let findings: Json = serde_json::from_str(&printed).expect("JSON");
    let rules: Vec<&Json> =
        findings.as_array().expect("a list").iter().map(|finding| &finding["rule"]).collect();
    assert_eq!(rules, ["missing-name", "unknown-type"]);
}

#[test]
fn summaries_count_changes_by_rule_and_category() {
    let folder = repository();
    write(
        folder.path(),
        "definitions/msg/Wind.msg",
        &format!("{}float64 gust  # [m/s] Gust\n", CALM.replace("[us]", "[ms]")),
    );
    let against = ["--against", "before"];
    let (status, results, messages) = breaking(folder.path(), &[&against[..], &["--summary"]].concat());
    assert_eq!(status, Some(1), "{messages}");
    assert_eq!(
        results,
        "\
level    rule                changes  incompatible
error    field-added               1  source 1, json 1, cdr 1, uorb 1
error    field-removed             1  source 1, json 1, cdr 1, uorb 1
error    field-unit-changed        1  semantic 1

3 changes; incompatible: source 2, json 2, cdr 2, uorb 2, semantic 1
"
    );
    assert!(messages.starts_with("breaking: 1 file compared with 1 ("), "{messages}");
    let (_, results, _) =
        breaking(folder.path(), &[&against[..], &["--summary", "--format", "json"]].concat());
    let json: Json = serde_json::from_str(&results).expect("JSON");
    assert_eq!((&json["count"], &json["categories"]["cdr"]), (&3.into(), &2.into()));
    assert_eq!(json["rules"][2]["categories"], serde_json::json!({ "semantic": 1 }));
}

#[test]
fn reports_only_selected_rules_and_categories() {
    let folder = repository();
    let run = |arguments: &[&str]| breaking(folder.path(), &[&["--against", "before"], arguments].concat());
    let (status, results, _) = run(&["--category", "cdr", "--category", "uorb"]);
    assert_eq!(status, Some(1));
    assert!(results.contains("= cdr: ") && !results.contains("= json: "), "{results}");
    assert!(results.ends_with("1 change; incompatible: cdr 1, uorb 1\n"), "{results}");
    let (status, results, _) = run(&["--category", "semantic"]);
    assert_eq!(status, Some(0), "{results}");
    assert_eq!(results, "no relevant changes; 1 other change hidden by options\n");
    assert_eq!(run(&["--rule", "field-added"]).0, Some(0));
    assert_eq!(run(&["--rule", "field-removed"]).0, Some(1));
    for (arguments, similar) in
        [(["--rule", "field-remved"], "field-removed"), (["--category", "sematic"], "semantic")]
    {
        let (status, _, messages) = run(&arguments);
        assert_eq!(status, Some(2));
        assert!(messages.contains(&format!("a similar value exists: '{similar}'")), "{messages}");
    }
}
