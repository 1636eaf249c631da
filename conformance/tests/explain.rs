//! Tests of `uavspec explain`.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use uavspec_test_support::shared;

/// Runs `uavspec explain`, and returns its exit status, standard output and standard error.
fn explain(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let output = command.arg("explain").args(arguments).current_dir(folder).output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Definitions without comments. The labels therefore come from the built-in definitions.
const BATTERY: &str = "uint64 timestamp
uint8 warning
uint8 BATTERY_WARNING_NONE = 0
uint8 BATTERY_WARNING_LOW = 1
uint8 BATTERY_WARNING_CRITICAL = 2
";

/// JSON Lines with battery warnings.
fn batteries(warnings: &[(u64, u8)]) -> String {
    let status = |(time, warning): &(u64, u8)| {
        let message = json!({ "timestamp": time, "warning": warning });
        format!("{}\n", json!({ "type": "px4/BatteryStatus", "message": message }))
    };
    warnings.iter().map(status).collect()
}

/// A folder with definitions and a flight.
fn folder_with_flight(flight: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("msg")).expect("a folder");
    fs::write(folder.path().join("msg/BatteryStatus.msg"), BATTERY).expect("a file");
    fs::write(folder.path().join("flight.jsonl"), flight).expect("a file");
    folder
}

#[test]
fn prints_the_timeline_and_writes_a_page() {
    let folder =
        folder_with_flight(&batteries(&[(1_000_000, 0), (62_500_000, 1), (63_000_000, 1), (64_000_000, 2)]));
    let flight = ["flight.jsonl", "--definitions", "msg"];
    let explain = |more: &[&str]| explain(folder.path(), &[&flight[..], more].concat());
    let (status, printed, errors) = explain(&["--report", "html=timeline.html"]);
    assert_eq!((status, errors.as_str()), (Some(0), ""));
    for line in [
        "flight.jsonl: 01:03.000 long, explained by msg",
        "    at start  battery_status.warning: NONE",
        "   01:01.500  battery_status.warning: LOW",
        "   01:03.000  battery_status.warning: CRITICAL",
        "\n3 changes.\n",
    ] {
        assert!(printed.contains(line), "{line}: {printed}");
    }
    let page = fs::read_to_string(folder.path().join("timeline.html")).expect("a page");
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg"), "{page}");

    let (status, printed, _) = explain(&["--format=json"]);
    let timeline: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!((status, &timeline["lanes"][0]["changes"][2]["time_us"]), (Some(0), &json!(63_000_000)));
    let (_, printed, _) = explain(&["--language", "UK"]);
    assert!(printed.contains("LOW – Низьк"), "{printed}");
}

#[test]
fn draws_a_flight_of_any_length() {
    let folder = folder_with_flight(&batteries(&[(0, 0), (1, 1), (u64::MAX, 2)]));
    let page = folder.path().join("timeline.html");
    let (status, _, errors) =
        explain(folder.path(), &["flight.jsonl", "--definitions", "msg", "--report", "html=timeline.html"]);
    assert_eq!(status, Some(0), "{errors}");
    assert!(fs::read_to_string(page).expect("a page").ends_with("</html>\n"));
}

#[test]
fn reports_wrong_usage_and_unreadable_captures() {
    let whole = batteries(&[(1_000_000, 0), (2_000_000, 1)]);
    let folder = folder_with_flight(&whole);
    for (name, text) in [
        ("cut.jsonl", &whole[..whole.len() - 20]),
        ("other.jsonl", "{\"type\": \"px4/Glider\", \"message\": {\"timestamp\": 7}}\n"),
        ("status.jsonl", "{\"type\": \"px4/VehicleStatus\", \"message\": {\"timestamp\": 7}}\n"),
        ("notes.txt", "These are notes."),
    ] {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    for (arguments, expected, message) in [
        (&["absent.ulg"][..], 3, "error: absent.ulg: no such file or folder"),
        (&["vehicle_status", "--language", "uk"], 3, "error: vehicle_status: no such file or folder"),
        (&["vehicle_statu"], 2, "help: did you mean vehicle_status?"),
        (&["134", "--release", "px4@1.2"], 2, "error: --release px4@1.2: unknown release"),
        (&["134", "--release", "px4@1.16", "--language", "uk"], 2, "cannot be used with"),
        (&["flight.jsonl", "--release", "px4@1.16"], 2, "help: use `--definitions px4@1.16` for a capture"),
        (&["a\u{1b}[31m\nb"], 2, "error: a\\u{1b}[31m\\nb: unknown"),
        (&["notes.txt"], 3, "error: notes.txt: unknown file type"),
        (&["flight.jsonl", "--language", "xx"], 2, "help: expected one of en, uk"),
        (&["flight.jsonl", "--report", "html=flight.jsonl"], 2, "would overwrite the input flight.jsonl"),
        (&["flight.jsonl", "--report", "pdf=a.pdf"], 2, "expected html=FILE"),
        (&["flight.jsonl", "--report", "html=absent/a.html"], 3, "can't write the report"),
        (&["flight.jsonl", "--definitions", "absent"], 2, "absent"),
        (&["flight.jsonl"], 5, "help: 2 messages can't be read"),
        (&["cut.jsonl", "--definitions", "msg"], 6, "incomplete: 1 part of the capture can't be read"),
        (&["other.jsonl"], 5, "help: the capture contains no topics of the timeline"),
        (
            &["status.jsonl", "--definitions", "msg"],
            5,
            "help: specify the definitions of vehicle_status with",
        ),
    ] {
        let (status, _, errors) = explain(folder.path(), arguments);
        assert_eq!(status, Some(expected), "{arguments:?}: {errors}");
        assert!(errors.contains(message), "{arguments:?}: {errors}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("flight.jsonl")).expect("a file"), whole);
}

#[test]
fn explains_words_that_are_no_paths() {
    let folder = folder_with_flight("");
    let (status, printed, errors) = explain(folder.path(), &["134"]);
    assert_eq!((status, errors.as_str()), (Some(0), ""));
    assert!(printed.starts_with("Error code 134 LOWBAT: error\n"), "{printed}");
    let (status, printed, _) = explain(folder.path(), &["vehicle_status.nav_state=17", "--format", "json"]);
    assert_eq!(
        (status, printed.starts_with("{\n  \"word\": \"vehicle_status.nav_state=17\",\n")),
        (Some(0), true)
    );
    // An existing file is treated as a capture, even if its name is a word.
    fs::write(folder.path().join("134"), "notes").expect("a file");
    let (status, _, errors) = explain(folder.path(), &["134"]);
    assert_eq!(status, Some(3), "{errors}");
}

#[test]
fn explains_real_logs() {
    let Some((logs, definitions)) = shared("corpus/ulog").zip(shared("corpus/px4/1.13")) else { return };
    let definitions = definitions.to_str().expect("a path");
    for (log, expected) in [
        ("sample.ulg", &["at start  vehicle_status.nav_state: MANUAL – Manual mode"][..]),
        (
            "sample_log_small.ulg",
            &[
                "at start  vehicle_status.arming_state: ARMED",
                "00:05.520  vehicle_status.arming_state: STANDBY",
                "00:05.520  vehicle_status.latest_disarming_reason: AUTO_DISARM_LAND",
                "at start  battery_status.warning (instance 1): NONE",
                "starts 2021-04-21T06:30:58.437Z",
            ],
        ),
        (
            "sample_logging_tagged_and_default_params.ulg",
            &["event: event 17980399 (component 1, number 1203183), log levels 6"],
        ),
    ] {
        let (status, printed, errors) = explain(&logs, &[log, "--definitions", definitions]);
        assert_eq!(status, Some(0), "{log}: {errors}");
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        for text in expected {
            assert!(words(&printed).contains(&words(text)), "{log}: {text}: {printed}");
        }
        assert!(printed.lines().all(|line| line.chars().count() <= 80), "{printed}");
    }
}

#[test]
fn explains_real_sessions() {
    let Some(sessions) = shared("corpus/flockwave") else { return };
    let (status, printed, errors) = explain(&sessions, &["clean.jsonl"]);
    assert_eq!(status, Some(0), "{errors}");
    for text in [
        "04:08:12.723  UAV-INF.4 INIT (03) cleared",
        "04:08:14.129  UAV-INF.5 TAKEOFF (00) set – Taking off\n",
        "at start  UAV-INF.mode (00): stab",
    ] {
        assert!(printed.contains(text), "{text}: {printed}");
    }
}
