//! Tests that no output replaces an input or another output.

use std::fs::{self, File, OpenOptions};
use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;

/// A message that the built-in definitions contain.
const MESSAGE: &str = "{\"type\":\"px4/BatteryStatus\",\"message\":{}}\n";

/// A folder with one file of each kind of input. All files have different content.
fn workspace() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for sub in ["logs", "msg", "schemas"] {
        fs::create_dir(folder.path().join(sub)).expect("a folder");
    }
    let config = "[[package]]\nname = \"px4\"\ndialect = \"px4\"\ninclude = [\"msg/*.msg\"]\n";
    for (name, text) in [
        ("logs/a.json", MESSAGE),
        ("msg/Wind.msg", "uint64 timestamp # [us] Time\n"),
        ("uavspec.toml", config),
        ("schemas/SOAR-INF.json", "{\"type\": \"object\"}"),
        ("known.toml", ""),
        ("ca.pem", "no certificate"),
        ("answers", "\n"),
        ("testee.sh", "exit 1\n"),
    ] {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// A command that runs the program in a folder, with these arguments.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command
}

/// All files in a folder with their content.
fn content(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let files = walkdir::WalkDir::new(folder).sort_by_file_name().into_iter().filter_map(Result::ok);
    let files = files.filter(|entry| !entry.file_type().is_dir()).map(walkdir::DirEntry::into_path);
    files.map(|path| (path.display().to_string(), fs::read(path).unwrap_or_default())).collect()
}

/// Asserts that the command rejects its arguments, and changes no file.
fn assert_rejected(folder: &Path, mut command: Command, wanted: &str) {
    let before = content(folder);
    let output = command.output().expect("it runs");
    let printed = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{wanted}: {printed}");
    assert!(printed.contains(wanted) && printed.contains("help: "), "{wanted}: {printed}");
    assert_eq!(content(folder), before, "{wanted}");
}

#[test]
fn a_report_never_replaces_a_capture() {
    let folder = workspace();
    let absolute = format!("json={}", folder.path().join("logs/a.json").display());
    for (report, input) in [
        ("json=logs/a.json", "logs/a.json"),
        ("html=./logs/a.json", "logs/a.json"),
        ("html=logs/../logs/a.json", "logs/a.json"),
        ("json=logs/a.json", "./logs/../logs/a.json"),
        (&absolute, "logs/a.json"),
        ("json=logs/a.json", "logs"),
        ("json=logs/a.json", "lo*/*.json"),
        ("json=logs/absent.json", "logs/absent.json"),
    ] {
        let command = command(folder.path(), &["check", "--report", report, input]);
        assert_rejected(folder.path(), command, "would overwrite the input");
    }
}

#[test]
fn commands_for_definitions_never_append_to_their_inputs() {
    for arguments in [
        &["lint"][..],
        &["lint", "--format", "json"],
        &["inspect"],
        &["fmt", "--check"],
        &["inspect", "--package", "px4", "--dialect", "px4", "--input", "msg"],
    ] {
        for input in ["msg/Wind.msg", "uavspec.toml"] {
            if input == "uavspec.toml" && arguments.contains(&"--package") {
                continue;
            }
            let folder = workspace();
            let output = OpenOptions::new().append(true).open(folder.path().join(input)).expect("a file");
            let mut command = command(folder.path(), arguments);
            command.stdout(output);
            assert_rejected(folder.path(), command, "standard output would overwrite the input");
        }
    }
}

#[test]
fn a_report_never_replaces_a_file_of_a_bag() {
    let folder = workspace();
    let text =
        "rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n  relative_file_paths:\n    - a.json\n";
    fs::write(folder.path().join("logs/metadata.yaml"), text).expect("a file");
    for (report, input) in [
        ("json=logs/a.json", "logs"),
        ("json=logs/metadata.yaml", "."),
        ("json=logs/a.json", "logs/metadata.yaml"),
    ] {
        let command = command(folder.path(), &["check", "--report", report, input]);
        assert_rejected(folder.path(), command, "would overwrite the input logs/");
    }
}

#[cfg(unix)]
#[test]
fn a_report_never_replaces_a_capture_through_a_link() {
    use std::os::unix::fs::symlink;

    let folder = workspace();
    let at = |name: &str| folder.path().join(name);
    symlink("logs/a.json", at("link.json")).expect("a link");
    symlink("link.json", at("chain.json")).expect("a link");
    symlink("logs", at("folder")).expect("a link");
    fs::hard_link(at("logs/a.json"), at("hard.json")).expect("a link");
    for output in ["link.json", "chain.json", "folder/a.json", "hard.json"] {
        let report = format!("json={output}");
        let forward = command(folder.path(), &["check", "--report", &report, "logs/a.json"]);
        assert_rejected(folder.path(), forward, "would overwrite the input logs/a.json");
        let back = command(folder.path(), &["check", "--report", "json=logs/a.json", output]);
        assert_rejected(folder.path(), back, "--report json=logs/a.json would overwrite");
    }
}

#[test]
fn a_report_never_replaces_a_redirected_stream() {
    let folder = workspace();
    let path = folder.path().join("logs/a.json");
    let mut reading = command(folder.path(), &["check", "--report", "json=logs/a.json", "-"]);
    reading.stdin(File::open(&path).expect("a file"));
    assert_rejected(folder.path(), reading, "would overwrite the input -");

    let append = || OpenOptions::new().append(true).open(&path).expect("a file");
    let mut writing = command(folder.path(), &["check", "--format", "json", "logs"]);
    writing.stdout(append());
    assert_rejected(folder.path(), writing, "standard output would overwrite the input logs/a.json");
    let mut watching = command(folder.path(), &["watch", "logs/a.json"]);
    watching.stdout(append());
    assert_rejected(folder.path(), watching, "standard output would overwrite the input logs/a.json");
    let mut both = command(folder.path(), &["check", "--report", "json=logs/a.json", "known.toml"]);
    both.stdout(append());
    assert_rejected(folder.path(), both, "--report json=logs/a.json and standard output are the same file");
}

#[test]
fn outputs_never_replace_definitions_or_lists() {
    let folder = workspace();
    for (arguments, wanted) in [
        (
            &["check", "--definitions", "msg", "--report", "json=msg/Wind.msg", "logs"][..],
            "input msg/Wind.msg",
        ),
        (&["check", "--definitions", ".", "--report", "json=uavspec.toml", "logs"], "uavspec.toml"),
        (&["check", "--baseline", "known.toml", "--report", "json=./known.toml", "logs"], "input known.toml"),
        (&["test", "--replay", "answers", "--report", "html=answers"], "input answers"),
        (&["test", "--report", "html=testee.sh", "--", "sh", "testee.sh"], "input testee.sh"),
        (
            &["test", "--definitions", "msg", "--dump-cases", "msg/Wind.msg"],
            "--dump-cases msg/Wind.msg would",
        ),
        (
            &["probe", "--baseline", "known.toml", "--record", "known.toml", "tcp://127.0.0.1:1"],
            "--record known.toml",
        ),
        (&["probe", "--ca", "ca.pem", "--record", "ca.pem", "tcps://127.0.0.1:1"], "input ca.pem"),
    ] {
        assert_rejected(folder.path(), command(folder.path(), arguments), wanted);
    }
}

#[cfg(feature = "schemas")]
#[test]
fn a_report_never_replaces_a_schema() {
    let folder = workspace();
    let schema = "schemas/SOAR-INF.json";
    let report = format!("json={schema}");
    let arguments = ["check", "--schema", "schemas", "--report", &report, "logs"];
    assert_rejected(folder.path(), command(folder.path(), &arguments), &format!("the input {schema}"));
}

#[test]
fn two_outputs_are_never_the_same_file() {
    let folder = workspace();
    fs::write(folder.path().join("old.html"), "old").expect("a file");
    for (arguments, wanted) in [
        (&["check", "--report", "json=a,html=./a", "logs"][..], "--report json=a and --report html=./a are"),
        (&["check", "--report", "json=old.html,html=logs/../old.html", "logs"], "are the same file"),
        (&["check", "--report", "json=a,parquet=./a", "logs"], "are the same file"),
        (&["lint", "--report", "sarif=a,junit=./a"], "the reports a and ./a are the same file"),
        (
            &["check", "--report", "json=new", "--write-baseline", "new", "logs"],
            "--report json=new and --write-baseline",
        ),
        (&["probe", "--record", "a", "--report", "json=a", "tcp://127.0.0.1:1"], "--record a and --report"),
    ] {
        assert_rejected(folder.path(), command(folder.path(), arguments), wanted);
    }
}

#[cfg(unix)]
#[test]
fn two_outputs_are_never_the_target_of_one_link() {
    let folder = workspace();
    std::os::unix::fs::symlink("logs/new", folder.path().join("link")).expect("a link");
    let command = command(folder.path(), &["check", "--report", "json=link,html=logs/new", "logs"]);
    assert_rejected(folder.path(), command, "are the same file");
}

#[cfg(unix)]
#[test]
fn writes_reports_to_pipes_devices_and_absent_targets_of_links() {
    use std::os::unix::fs::symlink;

    let folder = workspace();
    let at = |name: &str| folder.path().join(name);
    symlink("/dev/stdout", at("pipe")).expect("a link");
    symlink("logs/new.html", at("link")).expect("a link");
    let reports = "json=pipe,junit=/dev/null,sarif=/dev/null,html=link";
    let output = command(folder.path(), &["check", "--report", reports, "logs/a.json"]).output();
    let output = output.expect("it runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(output.stderr.is_empty() && printed.contains("\n  \"outcome\": {"), "{printed}");
    assert!(at("pipe").is_symlink() && at("link").is_symlink());
    assert!(at("logs/new.html").is_file());
}

/// If the disk is full, a report that couldn't be written must not look like one without findings.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_in_each_command() {
    let folder = workspace();
    for arguments in [
        &["serve", "--list-bugs"][..],
        &["serve", "--list-bugs", "--format", "json"],
        &["rules"],
        &["explain", "FW-ENV-01"],
        &["completions", "bash"],
        &["man"],
        &["check", "logs"],
        &["check", "--format", "json", "logs"],
        &["test", "--dump-cases", "-"],
        &["init", "new"],
        &["lint"],
        &["lint", "--rules"],
        &["inspect"],
        &["--help"],
        &["--version"],
    ] {
        let full = OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let output = command(folder.path(), arguments).stdout(full).output().expect("it runs");
        let printed = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(matches!(output.status.code(), Some(2 | 3)), "{arguments:?}: {:?} {printed}", output.status);
        let errors = printed.matches("No space left on device").count();
        assert_eq!(errors, 1, "{arguments:?}: {printed}");
    }
}
