//! Tests of servers that repeat secrets. No output of the program may contain them.

use std::path::Path;

use uavspec_test_server::server::{answer_requests, custom_server};

use super::*;

/// The password of the login `pilot:hunter2!`, and a token in the query of the URL, in all forms in which a server may
/// repeat them.
const SECRETS: [&str; 4] = ["hunter2!", "cGlsb3Q6aHVudGVyMiE", "s3cr3t-token", "token="];
const LOGIN: [&str; 2] = ["--login", "pilot:hunter2!"];
const FORMATS: [&str; 5] = ["html", "json", "junit", "sarif", "markdown"];

/// Runs the program with reports in all formats. Returns everything that it prints and writes.
fn outputs(command: &[&str], folder: &Path) -> String {
    let reports = FORMATS.map(|format| format!("--report={format}={format}"));
    let run = Command::new(env!("CARGO_BIN_EXE_uavspec"))
        .args(command)
        .args(reports)
        .current_dir(folder)
        .output()
        .expect("uavspec runs");
    let mut all = String::from_utf8([run.stdout, run.stderr].concat()).expect("UTF-8");
    for file in std::fs::read_dir(folder).expect("a folder") {
        all += &std::fs::read_to_string(file.expect("a file").path()).expect("UTF-8");
    }
    all
}

/// Asserts that the outputs contain a text, but no secret.
fn assert_hidden(all: &str, text: &str) {
    assert!(all.contains(text), "{all}");
    for secret in SECRETS {
        assert!(!all.contains(secret), "{secret}: {all}");
    }
}

#[test]
fn outputs_contain_no_login_that_a_server_repeats() {
    let server = custom_server(|stream| {
        answer_requests(stream, |kind, request| {
            Some(match kind {
                "AUTH-INF" => json!({ "methods": ["basic"], "required": true }),
                "AUTH-REQ" => {
                    let reason = format!("{} (pilot:hunter2!) is not \"hunter2!\"", request["data"]);
                    json!({ "result": false, "reason": reason, "extra": 1 })
                }
                _ => json!({ "software": "hunter2!", "version": 1 }),
            })
        });
    });
    let folder = tempfile::tempdir().expect("a folder");
    let url = format!("tcp://{server}");
    let record = ["probe", &url, "--record", "session.jsonl", LOGIN[0], LOGIN[1]];
    assert_hidden(&outputs(&record, folder.path()), "the server refused the login");
    let recording = std::fs::read_to_string(folder.path().join("session.jsonl")).expect("a recording");
    assert!(recording.contains(r#""data":"(hidden)""#), "{recording}");
    assert_hidden(&outputs(&["check", "session.jsonl"], folder.path()), "session.jsonl");
}

#[test]
fn outputs_contain_no_query_that_a_server_repeats() {
    for (status, header) in
        [("404 Not Found", ""), ("302 Found", "Location: http://kite/?token=s3cr3t-token\r\n")]
    {
        let server = custom_server(move |mut stream| {
            let mut head = String::new();
            let mut reader = BufReader::new(&stream);
            while !head.ends_with("\r\n\r\n") && reader.read_line(&mut head).is_ok_and(|length| length > 0) {}
            // If a server closes the connection before it has read all data, its answer may be lost.
            let stated = head.to_lowercase();
            let stated = stated.split("content-length: ").nth(1).and_then(|rest| rest.lines().next());
            let length = stated.and_then(|text| text.parse().ok()).unwrap_or(0);
            let _ = reader.take(length).read_to_end(&mut Vec::new());
            let length = head.len();
            // The client may have left.
            let _ = write!(stream, "HTTP/1.1 {status}\r\n{header}Content-Length: {length}\r\n\r\n{head}");
        });
        let folder = tempfile::tempdir().expect("a folder");
        let url = format!("http://{server}/fleet?token=s3cr3t-token");
        let command = ["probe", &url, "--record", "session.jsonl", LOGIN[0], LOGIN[1], "--limit", "5"];
        assert_hidden(&outputs(&command, folder.path()), &format!("http://{server}/fleet"));
    }
}

#[test]
fn errors_about_arguments_contain_no_login() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in [
        &["probe", "tcp://hill:1", "--login", "hunter2!"][..],
        &["probe", "tcp://hill:1", "--login=hunter2!"],
        &["probe", "tcp://pilot:hunter2!@hill:1"],
        &["probe", "pilot:hunter2!@hill:1"],
        &["probe", "zenoh://pilot:hunter2!@hill:1"],
        &["probe", "foxglove://pilot:hunter2!@hill:1"],
        &["probe", "x://pilot:hunter2!@hill:1"],
        &["probe", "socketio://hill:1?token=s3cr3t-token"],
        &["watch", "http://hill:x/?token=s3cr3t-token"],
        &["serve", "--login", "hunter2!"],
        &["check", "https://pilot:hunter2!@hill:x/a.ulg?token=s3cr3t-token"],
    ] {
        let run = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .args(command)
            .current_dir(folder.path())
            .output()
            .expect("uavspec runs");
        let printed = String::from_utf8([run.stdout, run.stderr].concat()).expect("UTF-8");
        assert_hidden(&printed, "error");
    }
}
