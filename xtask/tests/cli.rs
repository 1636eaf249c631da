//! Tests of the command line: exit status, messages and file changes.

use std::fs;
use std::process::Command;

use quick_junit::{Report as Junit, TestCase, TestCaseStatus};
use serde_json::Value as Json;
use support::{read, tree, write, xtask};
use tempfile::TempDir;

use crate::support;

const CONFIG: &str = r#"
[output]
rust = "out/rust"
json_schema = "out/schemas"
docs = "out/docs"

[[package]]
name = "demo"
dialect = "px4"
include = ["msg/*.msg"]
"#;

const WIND: &str = "# Wind over ground\n\nuint64 timestamp  # [us] Since start\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n";
const GUST: &str = "uint64 timestamp  # [us] Since start\nWind peak  # The strongest wind\n";

/// A workspace with two messages.
fn workspace() -> TempDir {
    support::workspace(&[("uavspec.toml", CONFIG), ("msg/Wind.msg", WIND), ("msg/Gust.msg", GUST)])
}

/// Runs a command and returns the messages on standard error.
#[track_caller]
fn run(folder: &TempDir, arguments: &[&str], status: i32) -> String {
    support::run(folder, arguments, status).1
}

#[test]
fn generates_checks_and_writes_only_what_changed() {
    let folder = workspace();
    let errors = run(&folder, &["codegen", "--check"], 1);
    assert!(errors.contains("missing: "), "{errors}");
    assert!(!folder.path().join("out").exists(), "--check writes nothing");
    run(&folder, &["codegen"], 0);
    run(&folder, &["codegen", "--check"], 0);
    let written = fs::metadata(folder.path().join("out/rust/demo/wind.rs"))
        .expect("output")
        .modified()
        .expect("a time");
    let errors = run(&folder, &["codegen"], 0);
    assert!(errors.contains(": 0 written, 0 removed"), "{errors}");
    let untouched = fs::metadata(folder.path().join("out/rust/demo/wind.rs"))
        .expect("output")
        .modified()
        .expect("a time");
    assert_eq!(written, untouched);
    write(&folder, "msg/Wind.msg", &WIND.replace("60", "80"));
    let errors = run(&folder, &["codegen", "--check"], 1);
    assert!(errors.contains("changed: ") && errors.contains("run `codegen`"), "{errors}");
}

#[test]
fn works_from_any_subfolder_with_the_same_output() {
    let folder = workspace();
    run(&folder, &["codegen"], 0);
    let first = tree(folder.path().join("out"));
    fs::remove_dir_all(folder.path().join("out")).expect("removed");
    let output = xtask(folder.path().join("msg"), &["codegen"]);
    assert!(output.status.success());
    assert_eq!(tree(folder.path().join("out")), first);
}

#[test]
fn generates_typescript_and_python() {
    let folder = workspace();
    let outputs =
        "[output]\ntypescript = { path = \"out/node\", form = \"compiled\" }\npython = \"out/python\"\n";
    write(&folder, "uavspec.toml", &CONFIG.replace("[output]\n", outputs));
    run(&folder, &["codegen"], 0);
    for path in ["node/demo.js", "node/demo.cjs", "node/demo.d.cts", "python/demo.py", "python/py.typed"] {
        assert!(folder.path().join("out").join(path).exists(), "{path} is missing");
    }
    run(&folder, &["codegen", "--check"], 0);
    write(&folder, "uavspec.toml", &CONFIG.replace("[output]\n", "[output]\ntypescript = \"out/node\"\n"));
    run(&folder, &["codegen"], 0);
    assert_eq!(tree(folder.path().join("out/node")).len(), 3, "two modules and the manifest");
    let arguments = ["--package", "demo", "--dialect", "px4", "--input", "msg", "--out", "other"];
    run(&folder, &[&["codegen", "--emit", "typescript,python"], &arguments[..]].concat(), 0);
    assert!(folder.path().join("other/typescript/demo.ts").exists());
    assert!(folder.path().join("other/python/demo.py").exists());
}

#[test]
fn removes_orphans_but_never_user_files() {
    let folder = workspace();
    run(&folder, &["codegen"], 0);
    write(&folder, "out/rust/demo/mine.rs", "// mine\n");
    write(&folder, "out/docs/notes.md", "mine\n");
    fs::remove_file(folder.path().join("msg/Gust.msg")).expect("removed");
    let errors = run(&folder, &["codegen", "--check"], 1);
    assert!(errors.contains("orphaned: "), "{errors}");
    run(&folder, &["codegen"], 0);
    assert!(!folder.path().join("out/rust/demo/gust.rs").exists());
    assert!(folder.path().join("out/rust/demo/wind.rs").exists());
    assert_eq!(read(&folder, "out/rust/demo/mine.rs"), "// mine\n");
    assert_eq!(read(&folder, "out/docs/notes.md"), "mine\n");
}

#[test]
fn a_conflicting_user_file_is_an_error_and_nothing_is_written() {
    let folder = workspace();
    write(&folder, "out/rust/demo/wind.rs", "// mine\n");
    let errors = run(&folder, &["codegen"], 2);
    assert!(errors.contains("was not generated") && errors.contains("help: "), "{errors}");
    assert_eq!(tree(folder.path().join("out")), [("rust/demo/wind.rs".to_owned(), b"// mine\n".to_vec())]);
}

#[test]
fn ignores_paths_outside_the_folder_in_a_manifest() {
    let folder = workspace();
    run(&folder, &["codegen"], 0);
    write(&folder, "precious.txt", "keep\n");
    let manifest = folder.path().join("out/rust/.uavspec-manifest");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    let absolute = folder.path().join("precious.txt");
    fs::write(&manifest, format!("{text}../../precious.txt\n{}\n", absolute.display())).expect("written");
    run(&folder, &["codegen"], 0);
    assert!(absolute.exists());
}

#[cfg(unix)]
#[test]
fn rejects_links_in_the_output_folder() {
    let folder = workspace();
    fs::create_dir_all(folder.path().join("elsewhere")).expect("a folder");
    fs::create_dir_all(folder.path().join("out/rust")).expect("a folder");
    std::os::unix::fs::symlink(folder.path().join("elsewhere"), folder.path().join("out/rust/demo"))
        .expect("a link");
    let errors = run(&folder, &["codegen"], 2);
    assert!(errors.contains("is a symbolic link"), "{errors}");
    assert!(tree(folder.path().join("elsewhere")).is_empty());
}

#[test]
fn all_errors_are_reported_and_nothing_is_written() {
    let folder = workspace();
    write(&folder, "msg/Wind.msg", "uint64 timestamp\nuint8 MODE = 300\nWnd peak\n");
    write(&folder, "msg/Gust.msg", "uint8[0] a\n");
    let errors = run(&folder, &["codegen"], 1);
    for code in [
        "constant-out-of-range",
        "unknown-type",
        "zero-length",
        "did you mean",
        "msg/Wind.msg:2:14",
        "msg/Gust.msg:1:6",
    ] {
        assert!(errors.contains(code), "{code} is missing in\n{errors}");
    }
    assert!(errors.contains("codegen: 3 errors in 2 of 2 files; nothing written"), "{errors}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn failures_have_status_2_and_a_hint() {
    let folder = workspace();
    fs::create_dir(folder.path().join("empty")).expect("a folder");
    write(&folder, "invalid.toml", "[[package]]\nname = \"demo\"\ndialekt = \"px4\"\n");
    write(&folder, "nothing.toml", "[output]\n");
    write(
        &folder,
        "unmatched.toml",
        "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"nowhere/*.msg\"]\n",
    );
    let direct = ["codegen", "--package", "p", "--dialect", "px4", "--input"];
    for (arguments, expected) in [
        (&[&direct[..], &["empty", "--out", "o"]].concat()[..], "no definitions in empty"),
        (&[&direct[..], &["absent", "--out", "o"]].concat(), "absent: No such file"),
        (&[&direct[..], &["uavspec.toml", "--out", "o"]].concat(), "is not a definition of this dialect"),
        (&[&direct[..], &["msg", "--out", "uavspec.toml/o"]].concat(), "uavspec.toml/o"),
        (&[&direct[..], &["msg"]].concat(), "--out"),
        (&["codegen", "--package", "p"], "--dialect"),
        (&["codegen", "--config", "invalid.toml"], "unknown field `dialekt`"),
        (&["codegen", "--config", "nothing.toml"], "has no packages"),
        (&["codegen", "--config", "unmatched.toml"], "matches no file"),
        (&["codegen", "--config", "absent.toml"], "absent.toml"),
        (&["codegen", "--bogus"], "--bogus"),
    ] {
        let errors = run(&folder, arguments, 2);
        assert!(errors.contains(expected), "{arguments:?}: expected `{expected}` in\n{errors}");
    }
    assert!(!folder.path().join("o").exists());
}

#[test]
fn reports_invalid_files_and_ignores_folders() {
    let folder = workspace();
    fs::create_dir(folder.path().join("msg/Folder.msg")).expect("a folder");
    fs::write(folder.path().join("msg/Wind.msg"), b"uint8 a # \xff\n").expect("a file");
    let errors = run(&folder, &["codegen"], 1);
    assert!(errors.contains("invalid-utf8") && errors.contains("msg/Wind.msg:1:11"), "{errors}");
}

#[test]
fn works_without_a_configuration_file() {
    let folder = workspace();
    let arguments = [
        "codegen",
        "--package",
        "demo",
        "--dialect",
        "px4",
        "--input",
        "msg",
        "--out",
        "made",
        "--emit",
        "rust,docs",
    ];
    run(&folder, &arguments, 0);
    assert!(folder.path().join("made/rust/mod.rs").exists());
    assert!(folder.path().join("made/docs/README.md").exists());
    assert!(!folder.path().join("made/json_schema").exists());
    run(&folder, &[&arguments[..], &["--check"]].concat(), 0);
}

#[test]
fn inspect_prints_the_model() {
    let folder = workspace();
    let output =
        xtask(folder.path(), &["inspect", "--package", "demo", "--dialect", "px4", "--input", "msg"]);
    assert!(output.status.success());
    let model: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    let wind = &model["packages"]["demo"]["messages"]["Wind"];
    assert_eq!(wind["fields"][1]["unit"], "m/s");
    assert_eq!(wind["fields"][1]["range"], serde_json::json!([0, 60]));
    assert_eq!(wind["uorb"]["size"], 16);
    assert_eq!(wind["topics"], serde_json::json!(["wind"]));
}

/// A workspace with findings of each level: trailing white space, a missing unit, and an unknown type.
fn careless() -> TempDir {
    let folder = workspace();
    write(
        &folder,
        "msg/Gust.msg",
        "uint64 timestamp  # [us] Since start \nfloat32 peak  # 50%, the strongest\n",
    );
    write(&folder, "msg/Sail trim.msg", "Wnd wind\n");
    folder
}

/// The rule, level, file and line of each finding in [`careless`]. The argument `note` contains the format's name for
/// the level `note`. Other rules may have further findings.
const fn expected(note: &'static str) -> [(&'static str, &'static str, &'static str, u64); 4] {
    [
        ("trailing-white-space", note, "msg/Gust.msg", 1),
        ("unit-missing", "warning", "msg/Gust.msg", 2),
        ("message-name", "error", "msg/Sail trim.msg", 1),
        ("unknown-type", "error", "msg/Sail trim.msg", 1),
    ]
}

/// Runs `lint` and returns the report. Standard error must contain only the summary.
#[track_caller]
fn lint(folder: &TempDir, format: &str, status: i32) -> String {
    let output = xtask(folder.path(), &["lint", "--format", format]);
    let errors = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{errors}");
    assert!(errors.starts_with("lint: ") && errors.lines().count() == 1, "{errors}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn lint_reports_json() {
    let list: Json = serde_json::from_str(&lint(&careless(), "json", 1)).expect("JSON");
    let list = list.as_array().expect("a list");
    for (rule, level, file, line) in expected("note") {
        let found =
            list.iter().find(|found| found["rule"] == rule).unwrap_or_else(|| panic!("{rule}: {list:?}"));
        assert_eq!((&found["level"], &found["file"]), (&level.into(), &file.into()));
        assert_eq!(found["start"]["line"], line);
        assert_eq!(found["fixable"], rule == "trailing-white-space");
    }
}

#[test]
fn lint_reports_sarif() {
    let log: Json = serde_json::from_str(&lint(&careless(), "sarif", 1)).expect("JSON");
    let run = &log["runs"][0];
    let results = run["results"].as_array().expect("results");
    for (rule, level, file, line) in expected("note") {
        let result = results.iter().find(|result| result["ruleId"] == rule);
        let result = result.unwrap_or_else(|| panic!("{rule}: {results:?}"));
        let at = &result["locations"][0]["physicalLocation"];
        assert_eq!(result["level"], level);
        assert_eq!(at["artifactLocation"]["uri"], file.replace(' ', "%20"));
        assert_eq!(at["region"]["startLine"], line);
        let index = result["ruleIndex"].as_u64().and_then(|index| usize::try_from(index).ok());
        assert_eq!(run["tool"]["driver"]["rules"][index.expect("an index")]["id"], rule);
    }
}

#[test]
fn lint_reports_junit() {
    let read = |text: String| Junit::deserialize_from_str(&text).expect("JUnit");
    let report = read(lint(&careless(), "junit", 1));
    let cases = &report.test_suites[0].test_cases;
    for (rule, level, file, _) in expected("note") {
        let class = format!("lint.{rule}");
        let case = cases.iter().find(|case| case.classname.as_deref() == Some(&class));
        let case = case.unwrap_or_else(|| panic!("{rule}: {cases:?}"));
        assert!(case.name.starts_with(file), "{case:?}");
        assert_eq!(matches!(case.status, TestCaseStatus::NonSuccess { .. }), level != "note", "{case:?}");
    }
    let failed = cases.iter().filter(|case| matches!(case.status, TestCaseStatus::NonSuccess { .. })).count();
    assert_eq!((report.tests, report.failures), (cases.len(), failed));
    let report = read(lint(&workspace(), "junit", 0));
    let cases = &report.test_suites[0].test_cases;
    let passed = cases.iter().find(|case| case.classname.as_deref() == Some("lint.unit-missing"));
    let is_success = |case: &TestCase| matches!(case.status, TestCaseStatus::Success { .. });
    assert!(passed.is_some_and(is_success), "a rule without findings is a passed test: {cases:?}");
}

#[test]
fn lint_reports_workflow_commands() {
    let text = lint(&careless(), "github", 1);
    for (rule, level, file, line) in expected("notice") {
        let title = format!(",title={rule}::");
        let command = text.lines().find(|command| command.contains(&title));
        let command = command.unwrap_or_else(|| panic!("{rule}: {text}"));
        assert!(command.starts_with(&format!("::{level} file={file},line={line},")), "{command}");
    }
    assert!(text.lines().all(|line| line.starts_with("::")), "one command per line: {text}");
}

#[test]
fn rule_pages_are_optional() {
    let folder = workspace();
    run(&folder, &["codegen"], 0);
    assert!(!folder.path().join("out/docs/rules").exists());
    let docs = "docs = { path = \"out/docs\", rules = true }";
    write(&folder, "uavspec.toml", &CONFIG.replace("docs = \"out/docs\"", docs));
    run(&folder, &["codegen"], 0);
    assert!(folder.path().join("out/docs/rules/README.md").exists());
    write(&folder, "uavspec.toml", CONFIG);
    run(&folder, &["codegen"], 0);
    assert!(!folder.path().join("out/docs/rules/README.md").exists());
}

#[test]
fn the_table_of_contents_includes_additional_pages() {
    let folder = workspace();
    let docs = "docs = { path = \"out/docs\", contents = \"more.md\" }";
    write(&folder, "uavspec.toml", &CONFIG.replace("docs = \"out/docs\"", docs));
    let errors = run(&folder, &["codegen"], 2);
    assert!(errors.contains("more.md") && errors.contains("from `output.docs.contents`"), "{errors}");
    // Commands without documentation output don't need the file.
    run(&folder, &["lint"], 0);
    write(&folder, "more.md", "- [Flights](flights.md)\n");
    write(&folder, "out/docs/flights.md", "# Flights\n");
    run(&folder, &["codegen"], 0);
    let summary = read(&folder, "out/docs/SUMMARY.md");
    assert!(summary.ends_with("- [Flights](flights.md)\n"), "{summary}");
    run(&folder, &["codegen", "--check"], 0);
    assert!(folder.path().join("out/docs/flights.md").exists(), "additional pages are preserved");
    write(&folder, "more.md", "- [Winds](winds.md)\n");
    let errors = run(&folder, &["codegen", "--check"], 1);
    assert!(errors.contains("SUMMARY.md"), "{errors}");
}

#[test]
fn finds_ros2_packages_next_to_the_input() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder, "std_msgs/msg/Header.msg", "builtin_interfaces/Time stamp\nstring frame_id\n");
    write(&folder, "builtin_interfaces/msg/Time.msg", "int32 sec\nuint32 nanosec\n");
    write(&folder, "builtin_interfaces/msg/Duration.msg", "int32 sec\nuint32 nanosec\n");
    write(&folder, "demo_msgs/msg/Ping.msg", "std_msgs/Header header\nuint8 count 3\n");
    let input = ["inspect", "--package", "demo_msgs", "--dialect", "ros2", "--input", "demo_msgs"];
    let output = xtask(folder.path(), &input);
    let model: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(model["packages"]["demo_msgs"]["messages"]["Ping"]["fields"][0]["type"], "std_msgs/Header");
    let messages = model["packages"]["builtin_interfaces"]["messages"].as_object().expect("messages");
    assert_eq!(messages.keys().collect::<Vec<_>>(), ["Time"], "only referenced messages");
}

const UNTIDY: &str = "uint64   timestamp #[microseconds]Since start\r\nuint8 mode# Which one [@range 0,1]";
const TIDY: &str = "uint64 timestamp  # [us] Since start\nuint8 mode        # [@range 0, 1] Which one\n";

#[test]
fn fmt_writes_only_changed_files() {
    let folder = workspace();
    write(&folder, "msg/Mode.msg", UNTIDY);
    write(&folder, "msg/Gust.msg", TIDY);
    let time = || {
        let data = fs::metadata(folder.path().join("msg/Gust.msg"));
        data.and_then(|data| data.modified()).expect("a time")
    };
    let written = time();
    let errors = run(&folder, &["fmt"], 0);
    assert!(errors.contains("fmt: 3 files read, 2 formatted ("), "{errors}");
    assert_eq!(read(&folder, "msg/Mode.msg"), TIDY);
    let errors = run(&folder, &["fmt"], 0);
    assert!(errors.contains("fmt: 3 files read, 0 formatted ("), "{errors}");
    assert_eq!(time(), written, "a formatted file is not written");
    run(&folder, &["fmt", "--check"], 0);
    assert_eq!(tree(folder.path().join("msg")).len(), 3, "no temporary files remain");
}

#[test]
fn fmt_check_prints_a_patch_and_writes_nothing() {
    let folder = workspace();
    write(&folder, "msg/Mode.msg", UNTIDY);
    run(&folder, &["fmt"], 0);
    write(&folder, "msg/Mode.msg", &TIDY.replace("64 ", "64  "));
    let before = tree(folder.path());
    let output = xtask(folder.path(), &["fmt", "--check"]);
    let (patch, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(
        patch,
        "--- msg/Mode.msg\n+++ msg/Mode.msg\n@@ -1,2 +1,2 @@\n\
         -uint64  timestamp  # [us] Since start\n+uint64 timestamp  # [us] Since start\n \
         uint8 mode        # [@range 0, 1] Which one\n"
    );
    assert!(errors.contains("fmt: 3 files read, 1 unformatted; run `fmt`"), "{errors}");
    assert_eq!(tree(folder.path()), before);
}

#[test]
fn fmt_skips_files_with_errors_and_formats_the_others() {
    let folder = workspace();
    let invalid = "uint8   MODE = 300\nuint8[0]  a\n";
    write(&folder, "msg/Wind.msg", invalid);
    write(&folder, "msg/Gust.msg", "uint8   a\nNowhere  b\n");
    fs::write(folder.path().join("msg/Bytes.msg"), b"uint8  a # \xff\n").expect("a file");
    let errors = run(&folder, &["fmt"], 1);
    for expected in [
        "constant-out-of-range",
        "zero-length",
        "invalid-utf8",
        "3 errors in 2 of 3 files; these files stay unchanged",
    ] {
        assert!(errors.contains(expected), "{expected} is missing in\n{errors}");
    }
    assert_eq!(read(&folder, "msg/Wind.msg"), invalid);
    let laid_out = read(&folder, "msg/Gust.msg");
    assert_eq!(laid_out, "uint8 a\nNowhere b\n", "unknown types don't matter");
}

#[test]
fn fmt_works_without_a_configuration_file_and_skips_dependencies() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder, "std_msgs/msg/Header.msg", "string   frame_id\n");
    write(&folder, "demo_msgs/msg/Ping.msg", "std_msgs/Header   header\nuint8   count   3\n");
    write(&folder, "page.md", "## Warnings\n\nCode|Abbr|Description\n-|-|-\n64|A|x\n");
    run(&folder, &["fmt", "--package", "demo_msgs", "--dialect", "ros2", "--input", "demo_msgs"], 0);
    run(&folder, &["fmt", "--package", "codes", "--dialect", "table", "--input", "page.md"], 0);
    let text = |path: &str| fs::read_to_string(folder.path().join(path)).expect("a file");
    assert_eq!(text("demo_msgs/msg/Ping.msg"), "std_msgs/Header header\nuint8 count 3\n");
    assert_eq!(text("std_msgs/msg/Header.msg"), "string   frame_id\n");
    assert!(
        text("page.md").contains("| Code | Abbr | Description |\n|-----:|------|-------------|\n|   64 | A ")
    );
}

#[cfg(unix)]
#[test]
fn fmt_preserves_permissions_and_links() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};

    let folder = workspace();
    write(&folder, "elsewhere/Mode.msg", UNTIDY);
    let target = folder.path().join("elsewhere/Mode.msg");
    fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).expect("permissions");
    symlink(&target, folder.path().join("msg/Mode.msg")).expect("a link");
    run(&folder, &["fmt"], 0);
    assert!(folder.path().join("msg/Mode.msg").is_symlink());
    assert_eq!(fs::read_to_string(&target).expect("a file"), TIDY);
    assert_eq!(fs::metadata(&target).expect("a file").permissions().mode() & 0o777, 0o640);
    write(&folder, "msg/Wind.msg", "uint8   a\n");
    write(&folder, "msg/Gust.msg", "uint8   a\n");
    let gust = folder.path().join("msg/Gust.msg");
    fs::set_permissions(&gust, fs::Permissions::from_mode(0o440)).expect("permissions");
    let errors = run(&folder, &["fmt"], 2);
    assert!(errors.contains("msg/Gust.msg: the file is read-only") && errors.contains("help: "), "{errors}");
    let wind = read(&folder, "msg/Wind.msg");
    assert_eq!(wind, "uint8   a\n", "all files or none");
}

#[test]
fn every_command_has_help_with_an_example_in_80_columns() {
    for command in
        ["codegen", "fmt", "inspect", "lint", "translate", "breaking", "docs", "package", "interop", "bench"]
    {
        for option in ["-h", "--help"] {
            let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
                .args([command, option])
                .env("COLUMNS", "80")
                .output()
                .expect("xtask runs");
            let help = String::from_utf8(output.stdout).expect("UTF-8");
            assert!(output.status.success() && help.contains("\n  cargo xtask "), "{help}");
            assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
        }
    }
}
