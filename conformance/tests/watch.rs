//! Tests of the command `watch` in scripts.

use std::io::{BufRead as _, BufReader};
use std::process::Command;

use serde_json::json;
use uavspec_serve::{Options, Transport, error};
use uavspec_test_server::server::{custom_server, serve};

/// Runs uavspec. Returns the exit status, standard output and standard error.
///
/// # Panics
///
/// Panics if a signal ended the program.
fn uavspec(arguments: &[&str]) -> (i32, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_uavspec")).args(arguments).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let status = run.status.code().unwrap_or_else(|| panic!("{}", run.status));
    (status, text(run.stdout), text(run.stderr))
}

#[test]
fn prints_a_table_without_a_terminal() {
    let errors = vec![error("glider-2=193").expect("a code")];
    let (_server, address) = serve(Options { uavs: 12, errors, ..Options::default() }, Transport::Tcp);
    let (status, printed, output) = uavspec(&["watch", "--for", "600", &format!("tcp://{address}")]);
    assert_eq!((status, output.as_str()), (0, ""), "{printed}");
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines.len(), 13, "{printed}");
    assert!(lines[0].starts_with("ID         SEVERITY  MODE"), "{printed}");
    assert!(lines[2].starts_with("glider-2   fatal     stab"), "{printed}");
    assert!(lines[2].ends_with("193 MAG, 1 GROUND") && lines[12].starts_with("glider-12"), "{printed}");
}

#[test]
fn fails_if_the_server_ends_the_connection() {
    let address = custom_server(|stream| {
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).expect("a request");
    });
    let (status, printed, output) =
        uavspec(&["watch", "--once", "--for", "0.2", &format!("tcp://{address}")]);
    assert_eq!((status, printed.as_str()), (3, ""));
    assert!(output.starts_with(&format!("error: tcp://{address}: ")), "{output}");

    assert_eq!(uavspec(&["watch", "localhost"]).0, 2);
}

#[test]
fn prints_the_state_of_a_capture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.jsonl");
    let request = json!({ "timestamp": 7, "request_id": 3, "valid_registrations_mask": 4 });
    let line = json!({ "type": "px4/ArmingCheckRequest", "message": request });
    std::fs::write(&path, format!("{line}\n")).expect("a file");
    let path = path.to_str().expect("a path");
    let (status, printed, output) = uavspec(&["watch", path]);
    assert_eq!((status, output.as_str()), (0, ""), "{printed}");
    assert!(printed.contains("\nno reply  name unknown (registration 2)\n"), "{printed}");

    std::fs::write(path, "{\"type\": \"UAV-LIST\", \"ids\": []}\n").expect("a file");
    let (status, _, output) = uavspec(&["watch", path]);
    assert!(status == 3 && output.contains("no message was received on the displayed topics"), "{output}");

    let (status, printed, output) = uavspec(&["watch", "no-such-file.ulg"]);
    assert_eq!((status, printed.as_str()), (3, ""));
    assert!(output.starts_with("error: no-such-file.ulg: "), "{output}");
}

#[test]
fn options_must_apply_to_the_source() {
    for (arguments, text) in [
        (&["tcp://127.0.0.1:9", "--language", "uk"], "--language applies only to PX4 vehicles and captures"),
        (&["flight.ulg", "--login", "a:b"], "--login applies only to Flockwave servers"),
        (&["flight.ulg", "--language", "xx"], "--language xx: no such language"),
    ] {
        let (status, _, output) = uavspec(&[&["watch"][..], arguments].concat());
        assert!(status == 2 && output.contains(text), "{output}");
    }
}

#[cfg(not(feature = "dds"))]
#[test]
fn missing_transports_name_the_feature() {
    let (status, _, output) = uavspec(&["watch", "dds://0"]);
    assert!(status == 3 && output.contains("--features dds"), "{output}");
}
