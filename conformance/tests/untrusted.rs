//! Tests that names, arguments, contents and responses reach a terminal or a CI log only in escaped form.

#![cfg(unix)]

use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::{OsStrExt as _, OsStringExt as _};
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use uavspec_test_server::server::{answer_requests, custom_server};

/// Text that starts a new line, and would have a special effect there if it weren't escaped.
const HOSTILE: &str = "x\n::error::FORGED\nFORGED \u{1b}]0;t\u{7}\u{1b}[31m\r\u{9b}2J\u{202e}\u{2028}\u{200b}##[error]y##vso[task.complete]z";

const FORMATS: [&str; 7] = ["text", "short", "json", "junit", "sarif", "html", "markdown"];

/// Runs uavspec with colours. Checks both outputs, and returns them.
#[track_caller]
fn checked(folder: &Path, arguments: &[&OsStr]) -> String {
    let run = Command::new(env!("CARGO_BIN_EXE_uavspec"))
        .args(arguments)
        .current_dir(folder)
        .env("CLICOLOR_FORCE", "1")
        .output()
        .expect("uavspec runs");
    let mut printed = String::new();
    for output in [run.stdout, run.stderr] {
        let text = String::from_utf8(output).expect("UTF-8");
        assert_harmless(&text);
        printed += &text;
    }
    printed
}

#[track_caller]
fn assert_harmless(printed: &str) {
    let text = anstream::adapter::strip_str(printed).to_string();
    let is_hidden = |character: char| {
        character.is_control() && character != '\n'
            || matches!(character, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    assert!(!text.contains(is_hidden) && !text.contains("##[") && !text.contains("##vso["), "{text:?}");
    let is_forged = |line: &str| {
        let name = line.trim_start().strip_prefix("::").and_then(|name| name.chars().next());
        name.is_some_and(char::is_alphanumeric) || line.trim_start().starts_with("FORGED")
    };
    assert_eq!(text.lines().find(|line| is_forged(line)), None, "{text}");
    // A style that comes from the input would begin in the middle of a word.
    assert!(!printed.contains("\u{7}\u{1b}") && !printed.contains("t\u{1b}[31m"), "{printed:?}");
}

fn strings(arguments: &[&str]) -> Vec<OsString> {
    arguments.iter().map(OsString::from).collect()
}

/// A hostile file name without slashes.
fn name(extension: &str) -> OsString {
    format!("{HOSTILE}.{extension}").into()
}

fn message(topic: &str, name: &str) -> String {
    let message = json!({ "timestamp": 1, "arming_check_id": 1000, "mode_id": 3, "mode_executor_id": -1, "name": name, (name): 1 });
    json!({ "op": "publish", "topic": topic, "msg": message }).to_string()
}

#[test]
fn names_and_contents_of_files_are_harmless_in_all_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &OsStr, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    let session = json!({ "conn": HOSTILE, "dir": "in", "msg": { "$fw.version": HOSTILE, "id": HOSTILE, "body": { "type": HOSTILE } } });
    let topics = ["/fmu/in/unregister_ext_component", HOSTILE];
    let lines: Vec<String> = topics.iter().map(|topic| message(topic, HOSTILE)).collect();
    put(&name("jsonl"), &lines.join("\n"));
    put("::error::x.jsonl".as_ref(), &format!("{session}\n{HOSTILE}"));
    put(&name("txt"), "");
    put(&name("mcap"), HOSTILE);
    put(&OsString::from_vec(b"\xff\x1b[2J\n::error::x.ulg".to_vec()), HOSTILE);
    for format in FORMATS {
        let printed =
            checked(folder.path(), &["check".as_ref(), "--format".as_ref(), format.as_ref(), ".".as_ref()]);
        assert!(printed.contains("task") || format == "short", "{format}: {printed}");
        let file = OsStr::from_bytes(b"\xfe\n::error::absent");
        checked(folder.path(), &["check".as_ref(), "--format".as_ref(), format.as_ref(), file]);
    }
    let report = folder.path().join("report.txt");
    checked(
        folder.path(),
        &["check".as_ref(), ".".as_ref(), "--report".as_ref(), "text=report.txt".as_ref()],
    );
    assert_harmless(&fs::read_to_string(report).expect("a report"));
}

#[test]
fn definitions_schemas_and_lists_are_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    let definitions = folder.path().join(HOSTILE.replace('/', ""));
    fs::create_dir(&definitions).expect("a folder");
    fs::write(
        definitions.join("Glider.msg"),
        format!("uint64 timestamp # {HOSTILE}\nfloat32 ##[error]\u{1b}]0;t\u{7}\n"),
    )
    .expect("a file");
    fs::write(definitions.join("SOAR-INF.json"), "{\"type\": \"::error::x\\u001b\"}").expect("a file");
    fs::write(folder.path().join("known.toml"), format!("[[known]]\nrule = {}\n", json!(HOSTILE)))
        .expect("a file");
    fs::write(folder.path().join("broken.toml"), format!("= \"{HOSTILE}")).expect("a file");
    let path = definitions.as_os_str();
    for option in ["--definitions", "--schema"] {
        checked(folder.path(), &["check".as_ref(), option.as_ref(), path, "absent".as_ref()]);
    }
    for list in ["known.toml", "broken.toml", HOSTILE] {
        checked(
            folder.path(),
            &["check".as_ref(), "--baseline".as_ref(), list.as_ref(), "known.toml".as_ref()],
        );
    }
}

#[test]
fn arguments_in_errors_are_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    let hostile = HOSTILE;
    let option = format!("--{hostile}");
    let value = format!("--format={hostile}");
    for arguments in [
        &[hostile][..],
        &["check", &option, "x"],
        &["check", &value, "x"],
        &["check", hostile],
        &["check", "--type", hostile, "x"],
        &["check", "--report", hostile, "x"],
        &["check", "--report", &format!("{hostile}=x"), "x"],
        &["check", "--report", &format!("html={hostile},json={hostile}"), "x"],
        &["check", "--require", hostile, "x"],
        &["rules", hostile],
        &["probe", hostile],
        &["probe", &format!("tcp://{hostile}:1")],
        &["probe", "--only", hostile, "tcp://127.0.0.1:1"],
        &["probe", "--ca-file", hostile, "tcps://127.0.0.1:1"],
        &["watch", &format!("http://localhost:1/{hostile}?{hostile}")],
        &["serve", "--error", &format!("{hostile}=1")],
        &["serve", "--error", hostile],
        &["serve", "--lose", &format!("{hostile}@1")],
        &["serve", "--bug", hostile],
        &["test", "--", &format!("./{hostile}")],
        &["test", "--filter", hostile, "--", "true"],
        &["test", "--replay", hostile],
        &["testee", "lint", "--only", hostile, "--", "true"],
        &["testee", "lint", "--attach", hostile],
    ] {
        let arguments = strings(arguments);
        let arguments: Vec<&OsStr> = arguments.iter().map(OsString::as_os_str).collect();
        checked(folder.path(), &arguments);
    }
}

#[test]
fn responses_of_a_testee_are_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    let hello = json!({ "hello": { "name": HOSTILE, "version": HOSTILE } });
    fs::write(
        folder.path().join("answers"),
        format!("{hello}\n{{\"id\": \"{}\"}}\n{HOSTILE}\n", "\\u001b\\n::error::"),
    )
    .expect("a file");
    let program = "cat answers; cat answers >&2; exit 7";
    for arguments in [
        &["test", "--", "sh", "-c", program][..],
        &["test", "--format", "junit", "--", "sh", "-c", program],
        &["test", "--format", "markdown", "--replay", "answers"],
        &["testee", "lint", "--", "sh", "-c", program],
        &["testee", "lint", "--format", "json", "--", "sh", "-c", program],
    ] {
        let arguments = strings(arguments);
        let arguments: Vec<&OsStr> = arguments.iter().map(OsString::as_os_str).collect();
        checked(folder.path(), &arguments);
    }
}

/// A body in which every text is hostile.
fn body(kind: &str) -> Value {
    match kind {
        "UAV-LIST" => json!({ "ids": [HOSTILE] }),
        "UAV-INF" => {
            let errors: Vec<Value> = vec![json!(HOSTILE)];
            let state = json!({ "id": HOSTILE, "timestamp": HOSTILE, "mode": HOSTILE, "errors": errors });
            json!({ "status": { (HOSTILE): state }, "error": { (HOSTILE): HOSTILE } })
        }
        _ => {
            json!({ "software": HOSTILE, "version": HOSTILE, "methods": [HOSTILE], "reason": HOSTILE, (HOSTILE): HOSTILE })
        }
    }
}

#[test]
fn responses_of_a_server_are_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    let address = custom_server(|stream| answer_requests(stream, |kind, _| Some(body(kind))));
    let url = format!("tcp://{address}");
    for arguments in [
        &["probe", "--no-trials", "--for", "0.2", "--limit", "2", &url][..],
        &["probe", "--no-trials", "--for", "0.2", "--limit", "2", "--format", "markdown", &url],
        &["watch", "--once", "--for", "2", &url],
    ] {
        let arguments = strings(arguments);
        let arguments: Vec<&OsStr> = arguments.iter().map(OsString::as_os_str).collect();
        let printed = checked(folder.path(), &arguments);
        assert!(printed.contains("task") || printed.contains('…'), "{printed}");
    }
}
