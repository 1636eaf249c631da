//! Tests of commands that are limited to some files, and of report files.

use serde_json::Value as Json;
use support::{CONFIG, read, run, write};
use tempfile::TempDir;

use crate::support;

const WIND: &str = "# Wind\n\nuint64 timestamp # [us] Time\nfloat32   speed # Speed\n";

/// A message that refers to another message.
const GUST: &str =
    "# Gust\n\nuint64 timestamp # [us] Time\nWind   peak # Peak\nfloat32 duration # Duration\n";

fn workspace() -> TempDir {
    let odd = ("other/Odd.msg", "uint8   odd\n");
    support::workspace(&[("uavspec.toml", CONFIG), ("msg/Wind.msg", WIND), ("msg/Gust.msg", GUST), odd])
}

#[test]
fn fmt_changes_only_the_given_files() {
    let folder = workspace();
    let (_, errors) = run(&folder, &["fmt", "other/Odd.msg", "./msg/../msg/Gust.msg"], 0);
    assert!(errors.starts_with("warning: other/Odd.msg doesn't belong to a package; skipped\n"), "{errors}");
    assert!(errors.contains("1 formatted"), "{errors}");
    assert_ne!(read(&folder, "msg/Gust.msg"), GUST);
    assert_eq!(
        (read(&folder, "msg/Wind.msg").as_str(), read(&folder, "other/Odd.msg").as_str()),
        (WIND, "uint8   odd\n")
    );
    run(&folder, &["fmt", "--check", "msg/Gust.msg"], 0);
    run(&folder, &["fmt", "--check", "msg/Wind.msg"], 1);
    let (_, errors) = run(&folder, &["fmt", "msg/Absent.msg"], 2);
    assert!(errors.contains("error: msg/Absent.msg: "), "{errors}");
    // Errors in other files don't matter.
    write(&folder, "msg/Broken.msg", "uint8\n");
    run(&folder, &["fmt", "msg/Wind.msg"], 0);
    run(&folder, &["fmt", "msg/Broken.msg"], 1);
}

#[test]
fn lint_reports_and_fixes_only_the_given_files() {
    let folder = workspace();
    let (printed, _) = run(&folder, &["lint", "--deny", "warning", "msg/Gust.msg"], 1);
    assert!(printed.contains("msg/Gust.msg:5:1") && !printed.contains("msg/Wind.msg"), "{printed}");
    assert!(!printed.contains("unknown-type"), "the message that it refers to is read: {printed}");
    let (printed, errors) = run(&folder, &["lint", "--deny", "warning", "other/Odd.msg"], 0);
    assert!(
        printed.contains("hidden by options") && errors.contains("other/Odd.msg doesn't belong to a package"),
        "{printed}"
    );
    let fixable = "uint64 timestamp # [us] Time\nfloat32 angle # [radians] Angle\n";
    for name in ["One", "Two"] {
        write(&folder, &format!("msg/{name}.msg"), fixable);
    }
    run(&folder, &["lint", "--fix", "msg/One.msg"], 0);
    assert_ne!(read(&folder, "msg/One.msg"), fixable);
    assert_eq!(read(&folder, "msg/Two.msg"), fixable);
    // Findings are incomplete if a definition has errors.
    write(&folder, "msg/Broken.msg", "uint8\n");
    let (printed, _) = run(&folder, &["lint", "msg/Gust.msg"], 1);
    assert!(printed.contains("msg/Broken.msg:1"), "{printed}");
}

#[test]
fn reports_are_written_next_to_the_printed_findings() {
    let folder = workspace();
    let reports = [
        "lint",
        "--deny",
        "warning",
        "--report",
        "sarif=lint.sarif,codequality=lint.json",
        "--report",
        "text=lint.txt",
    ];
    let (printed, _) = run(&folder, &reports, 1);
    assert_eq!(read(&folder, "lint.txt"), printed);
    let sarif: Json = serde_json::from_str(&read(&folder, "lint.sarif")).expect("JSON");
    let issues: Json = serde_json::from_str(&read(&folder, "lint.json")).expect("JSON");
    let results = sarif["runs"][0]["results"].as_array().expect("results");
    assert!(!results.is_empty() && issues.as_array().is_some_and(|issues| issues.len() == results.len()));
    // `breaking` has the option as well.
    write(&folder, "old/Wind.msg", &WIND.replace("float32", "float64"));
    let breaking = ["breaking", "--against", "old", "--report", "junit=breaking.xml"];
    run(&folder, &breaking, 1);
    assert!(read(&folder, "breaking.xml").contains("breaking.field-type-changed"));
}

#[test]
fn a_report_replaces_no_input_and_no_other_report() {
    let folder = workspace();
    write(&folder, "known.toml", "");
    for input in ["msg/Wind.msg", "./uavspec.toml", "known.toml"] {
        let before = read(&folder, input);
        let (_, errors) =
            run(&folder, &["lint", "--baseline", "known.toml", "--report", &format!("json={input}")], 2);
        assert!(errors.contains("the report would overwrite the input"), "{errors}");
        assert_eq!(read(&folder, input), before);
    }
    let (_, errors) = run(&folder, &["lint", "--report", "json=a,sarif=a"], 2);
    assert!(errors.contains("the reports a and a are the same file"), "{errors}");
    let (_, errors) = run(&folder, &["lint", "--report", "json=absent/a.json"], 2);
    assert!(errors.contains("absent/a.json: can't write the report"), "{errors}");
}

#[test]
fn findings_name_files_relative_to_the_current_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder, "interfaces/uavspec.toml", CONFIG);
    write(&folder, "interfaces/msg/Wind.msg", WIND);
    let (printed, _) = run(&folder, &["lint", "--config", "interfaces/uavspec.toml", "--format", "json"], 0);
    let findings: Vec<Json> = serde_json::from_str(&printed).expect("JSON");
    assert!(
        !findings.is_empty() && findings.iter().all(|finding| finding["file"] == "interfaces/msg/Wind.msg"),
        "{printed}"
    );
}
