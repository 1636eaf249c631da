//! The command line as a user meets it: exit status, messages, and what happens to files.

use crate::support;

use std::fs;
use std::path::Path;

use quick_junit::{Report as Junit, TestCase, TestCaseStatus};
use serde_json::Value as Json;
use tempfile::TempDir;

use support::{write, xtask};

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
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder, "uavspec.toml", CONFIG);
    write(&folder, "msg/Wind.msg", WIND);
    write(&folder, "msg/Gust.msg", GUST);
    folder
}

#[track_caller]
fn run(folder: &TempDir, arguments: &[&str], status: i32) -> String {
    let output = xtask(folder.path(), arguments);
    let errors = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(status), "{arguments:?}\n{errors}");
    errors
}

/// Every file below a folder with its text.
fn tree(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in fs::read_dir(&at).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("below").to_string_lossy().into_owned();
                files.push((name, fs::read(&path).expect("a file")));
            }
        }
    }
    files.sort();
    files
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
    assert!(errors.contains("changed: ") && errors.contains("cargo xtask codegen"), "{errors}");
}

#[test]
fn works_from_any_folder_below_and_gives_the_same_bytes() {
    let folder = workspace();
    run(&folder, &["codegen"], 0);
    let first = tree(&folder.path().join("out"));
    fs::remove_dir_all(folder.path().join("out")).expect("removed");
    let output = xtask(folder.path().join("msg"), &["codegen"]);
    assert!(output.status.success());
    assert_eq!(tree(&folder.path().join("out")), first);
}

#[test]
fn typescript_and_python_are_outputs_like_the_others() {
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
    assert_eq!(tree(&folder.path().join("out/node")).len(), 3, "two modules and the list of them");
    let arguments = ["--package", "demo", "--dialect", "px4", "--input", "msg", "--out", "other"];
    run(&folder, &[&["codegen", "--emit", "typescript,python"], &arguments[..]].concat(), 0);
    assert!(folder.path().join("other/typescript/demo.ts").exists());
    assert!(folder.path().join("other/python/demo.py").exists());
}

#[test]
fn removes_orphans_but_never_a_file_of_the_user() {
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
    assert_eq!(fs::read_to_string(folder.path().join("out/rust/demo/mine.rs")).expect("kept"), "// mine\n");
    assert_eq!(fs::read_to_string(folder.path().join("out/docs/notes.md")).expect("kept"), "mine\n");
}

#[test]
fn a_file_of_the_user_in_the_way_is_an_error_and_nothing_is_written() {
    let folder = workspace();
    write(&folder, "out/rust/demo/wind.rs", "// mine\n");
    let errors = run(&folder, &["codegen"], 2);
    assert!(errors.contains("was not generated") && errors.contains("help: "), "{errors}");
    assert_eq!(tree(&folder.path().join("out")), [("rust/demo/wind.rs".to_owned(), b"// mine\n".to_vec())]);
}

#[test]
fn a_manifest_that_leads_out_of_its_folder_is_not_followed() {
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
fn a_link_inside_the_output_is_not_followed() {
    let folder = workspace();
    fs::create_dir_all(folder.path().join("elsewhere")).expect("a folder");
    fs::create_dir_all(folder.path().join("out/rust")).expect("a folder");
    std::os::unix::fs::symlink(folder.path().join("elsewhere"), folder.path().join("out/rust/demo"))
        .expect("a link");
    let errors = run(&folder, &["codegen"], 2);
    assert!(errors.contains("is a link"), "{errors}");
    assert!(tree(&folder.path().join("elsewhere")).is_empty());
}

#[test]
fn mistakes_are_shown_all_at_once_and_nothing_is_written() {
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
fn what_cannot_be_carried_out_is_status_2_with_a_hint() {
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
        (&[&direct[..], &["empty", "--out", "o"]].concat()[..], "no definitions below empty"),
        (&[&direct[..], &["absent", "--out", "o"]].concat(), "absent: No such file"),
        (&[&direct[..], &["uavspec.toml", "--out", "o"]].concat(), "no definition of this dialect"),
        (&[&direct[..], &["msg", "--out", "uavspec.toml/o"]].concat(), "uavspec.toml/o"),
        (&[&direct[..], &["msg"]].concat(), "--out"),
        (&["codegen", "--package", "p"], "--dialect"),
        (&["codegen", "--config", "invalid.toml"], "unknown field `dialekt`"),
        (&["codegen", "--config", "nothing.toml"], "names no package"),
        (&["codegen", "--config", "unmatched.toml"], "matches no file"),
        (&["codegen", "--config", "absent.toml"], "absent.toml"),
        (&["codegen", "--bogus"], "--bogus"),
    ] {
        let errors = run(&folder, arguments, 2);
        assert!(errors.contains(expected), "{arguments:?}: no `{expected}` in\n{errors}");
    }
    assert!(!folder.path().join("o").exists());
}

#[test]
fn a_folder_or_bytes_in_place_of_a_definition_are_named() {
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

/// A workspace with findings of each level: no unit, a blank at the end of a line, and a type that is none.
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

/// Rule, level, file and line of what [`careless`] has, with the level of notes in the word of a format. Other
/// rules may find more.
const fn expected(note: &'static str) -> [(&'static str, &'static str, &'static str, u64); 4] {
    [
        ("trailing-white-space", note, "msg/Gust.msg", 1),
        ("unit-missing", "warning", "msg/Gust.msg", 2),
        ("message-name", "error", "msg/Sail trim.msg", 1),
        ("unknown-type", "error", "msg/Sail trim.msg", 1),
    ]
}

/// What `lint` reports in a format. That goes to standard output alone, and the summary to standard error.
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
    assert!(passed.is_some_and(is_success), "a rule that found nothing is a test that passed: {cases:?}");
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
    assert!(text.lines().all(|line| line.starts_with("::")), "a command a line: {text}");
}

#[test]
fn pages_of_the_rules_are_written_where_they_are_asked_for() {
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
fn pages_that_others_write_stand_in_the_table_of_contents() {
    let folder = workspace();
    let docs = "docs = { path = \"out/docs\", contents = \"more.md\" }";
    write(&folder, "uavspec.toml", &CONFIG.replace("docs = \"out/docs\"", docs));
    let said = run(&folder, &["codegen"], 2);
    assert!(said.contains("more.md") && said.contains("`output.docs.contents` names it"), "{said}");
    // Commands that write no documentation don't need it.
    run(&folder, &["lint"], 0);
    write(&folder, "more.md", "- [Flights](flights.md)\n");
    write(&folder, "out/docs/flights.md", "# Flights\n");
    run(&folder, &["codegen"], 0);
    let summary = fs::read_to_string(folder.path().join("out/docs/SUMMARY.md")).expect("a table of contents");
    assert!(summary.ends_with("- [Flights](flights.md)\n"), "{summary}");
    run(&folder, &["codegen", "--check"], 0);
    assert!(folder.path().join("out/docs/flights.md").exists(), "what others write stays");
    write(&folder, "more.md", "- [Winds](winds.md)\n");
    let said = run(&folder, &["codegen", "--check"], 1);
    assert!(said.contains("SUMMARY.md"), "{said}");
}

#[test]
fn ros2_packages_beside_the_input_are_found() {
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
    assert_eq!(messages.keys().collect::<Vec<_>>(), ["Time"], "only what is referred to");
}

const UNTIDY: &str = "uint64   timestamp #[microseconds]Since start\r\nuint8 mode# Which one [@range 0,1]";
const TIDY: &str = "uint64 timestamp  # [us] Since start\nuint8 mode        # [@range 0, 1] Which one\n";

#[test]
fn fmt_lays_out_only_what_differs() {
    let folder = workspace();
    write(&folder, "msg/Mode.msg", UNTIDY);
    write(&folder, "msg/Gust.msg", TIDY);
    let time = || {
        let data = fs::metadata(folder.path().join("msg/Gust.msg"));
        data.and_then(|data| data.modified()).expect("a time")
    };
    let written = time();
    let errors = run(&folder, &["fmt"], 0);
    assert!(errors.contains("fmt: 3 files read, 2 laid out anew ("), "{errors}");
    assert_eq!(fs::read_to_string(folder.path().join("msg/Mode.msg")).expect("a file"), TIDY);
    let errors = run(&folder, &["fmt"], 0);
    assert!(errors.contains("fmt: 3 files read, 0 laid out anew ("), "{errors}");
    assert_eq!(time(), written, "what is laid out is not written");
    run(&folder, &["fmt", "--check"], 0);
    assert_eq!(tree(&folder.path().join("msg")).len(), 3, "nothing is left behind");
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
    assert!(errors.contains("fmt: 3 files read, 1 to be laid out anew; run `cargo xtask fmt`"), "{errors}");
    assert_eq!(tree(folder.path()), before);
}

#[test]
fn fmt_leaves_files_with_mistakes_and_lays_out_the_others() {
    let folder = workspace();
    let mistaken = "uint8   MODE = 300\nuint8[0]  a\n";
    write(&folder, "msg/Wind.msg", mistaken);
    write(&folder, "msg/Gust.msg", "uint8   a\nNowhere  b\n");
    fs::write(folder.path().join("msg/Bytes.msg"), b"uint8  a # \xff\n").expect("a file");
    let errors = run(&folder, &["fmt"], 1);
    for expected in
        ["constant-out-of-range", "zero-length", "invalid-utf8", "3 errors in 2 of 3 files; left as they are"]
    {
        assert!(errors.contains(expected), "{expected} is missing in\n{errors}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file"), mistaken);
    let laid_out = fs::read_to_string(folder.path().join("msg/Gust.msg")).expect("a file");
    assert_eq!(laid_out, "uint8 a\nNowhere b\n", "what a type is doesn't matter");
}

#[test]
fn fmt_works_without_a_configuration_file_and_leaves_dependencies_alone() {
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
fn fmt_keeps_permissions_and_links() {
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
    let wind = fs::read_to_string(folder.path().join("msg/Wind.msg")).expect("a file");
    assert_eq!(wind, "uint8   a\n", "all files or none");
}

#[test]
fn every_command_has_help_with_an_example() {
    let folder = workspace();
    for command in ["codegen", "fmt", "inspect", "lint", "translate", "bench"] {
        let output = xtask(folder.path(), &[command, "--help"]);
        let help = String::from_utf8(output.stdout).expect("UTF-8");
        assert!(output.status.success() && help.contains("cargo xtask "), "{help}");
    }
}
