//! `breaking` as a user meets it: against folders, and against revisions of a Git repository.

use crate::support;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value as Json;
use tempfile::TempDir;

use support::{write, xtask};

const CONFIG: &str = "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n";
const WIND: &str =
    "# Wind over ground\n\nuint64 timestamp  # [us] Since start\nfloat32 speed     # [m/s] Speed\n";
const CALM: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start\n";

/// Status, what was printed, and what was said.
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
    let output = output.expect("git runs: a clone of this repository needs it, and so does this test");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A repository in a folder whose first commit, tagged `before`, has a message with one field more than the
/// working tree.
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
fn a_revision_is_compared_with_the_working_tree() {
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
        let (status, _, said) = breaking(&folder.path().join(place), arguments);
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains("error[field-removed]: `Wind.speed` (float32) is gone"), "{said}");
        assert!(said.contains(&format!("--> {}:definitions/msg/Wind.msg:4:1", arguments[1])), "{said}");
        assert!(said.contains("1 change; they break source 1, json 1, cdr 1, uorb 1"), "{said}");
    }
    write(folder.path(), "definitions/msg/Wind.msg", &WIND.replace("Speed", "How fast it blows"));
    let (status, _, said) = breaking(folder.path(), &["--against", "before"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("nothing changed"), "{said}");
}

#[test]
fn definitions_that_moved_are_found_by_the_configuration_of_their_time() {
    let folder = repository();
    fs::rename(folder.path().join("definitions/msg"), folder.path().join("definitions/messages"))
        .expect("a folder");
    write(folder.path(), "definitions/uavspec.toml", &CONFIG.replace("msg/*", "messages/*"));
    let (status, _, said) = breaking(folder.path(), &["--against", "before"]);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("`Wind.speed`"), "{said}");
}

#[test]
fn findings_are_a_list_of_json_with_both_places() {
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
    assert_eq!(categories, ["source", "cdr", "uorb"], "floats of both widths are the same in JSON");
    for finding in findings {
        assert_eq!(finding["rule"], "field-type-changed");
        assert_eq!(finding["level"], "error");
        assert_eq!(finding["message"], "`Wind.speed` is float64, and was float32");
        assert_eq!(
            (&finding["old"]["file"], &finding["new"]["file"]),
            (&"old/Wind.msg".into(), &"new/Wind.msg".into())
        );
        assert_eq!(finding["new"]["start"], serde_json::json!({ "line": 4, "column": 1 }));
        assert_eq!(finding["new"]["end"], serde_json::json!({ "line": 4, "column": 14 }));
    }
}

/// What can't be carried out ends with 2 and says what to do.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], parts: &[&str]) {
    let (status, _, said) = breaking(folder, arguments);
    assert_eq!(status, Some(2), "{arguments:?}: {said}");
    for part in parts {
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
}

#[test]
fn what_cannot_be_carried_out_is_status_2_with_a_hint() {
    let folder = repository();
    let path = folder.path();
    refuses(
        path,
        &["--against", "nowhere"],
        &["`nowhere` is neither a folder nor a revision", "help: name a branch"],
    );
    refuses(path, &["--against=--upload-pack=x"], &["neither a folder nor a revision"]);
    fs::create_dir(path.join("empty")).expect("a folder");
    refuses(path, &["--against", "empty"], &["no definitions below empty", "help: the dialect px4"]);
    write(path, "definitions/uavspec.toml", &format!("{CONFIG}dialekt = \"px4\"\n"));
    refuses(
        path,
        &["--against", "before"],
        &["definitions/uavspec.toml:5:1", "unknown field `dialekt`", "help: the guide"],
    );
    write(path, "definitions/uavspec.toml", CONFIG);
    write(path, "broken/uavspec.toml", CONFIG);
    write(path, "broken/msg/Wind.msg", "uint64\n");
    refuses(path, &["--against", "broken"], &["the earlier definitions have mistakes", "missing-name"]);

    let outside = tempfile::tempdir().expect("a temporary folder");
    write(outside.path(), "uavspec.toml", CONFIG);
    write(outside.path(), "msg/Wind.msg", WIND);
    refuses(outside.path(), &["--against", "main"], &["is in no Git repository", "help: name a folder"]);
}

#[test]
fn a_shallow_clone_is_told_how_to_get_the_rest() {
    let folder = repository();
    git(folder.path(), &["commit", "--quiet", "--all", "--message", "Calm"]);
    let clone = tempfile::tempdir().expect("a temporary folder");
    let origin = format!("file://{}", folder.path().display());
    git(clone.path(), &["clone", "--quiet", "--depth", "1", "--no-tags", &origin, "copy"]);
    let hints = ["this clone is shallow", "git fetch --unshallow"];
    refuses(&clone.path().join("copy"), &["--against", "before"], &hints);
    refuses(&clone.path().join("copy"), &["--against", "HEAD~1"], &hints);
}

#[test]
fn mistakes_in_the_new_definitions_are_findings() {
    let folder = repository();
    write(folder.path(), "definitions/msg/Wind.msg", "uint64\nfoo bar\n");
    let (status, printed, _) = breaking(folder.path(), &["--against", "before", "--format", "json"]);
    assert_eq!(status, Some(1));
    let findings: Json = serde_json::from_str(&printed).expect("JSON");
    let rules: Vec<&Json> =
        findings.as_array().expect("a list").iter().map(|finding| &finding["rule"]).collect();
    assert_eq!(rules, ["missing-name", "unknown-type"]);
}
