//! Tests of `uavspec convert`: its output, its reports and its errors.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use mcap::records::MessageHeader;
use mcap::{MessageStream, WriteOptions};
use serde_json::Value;
use tempfile::TempDir;

/// The definition of `ArmingCheckRequest` in PX4 1.16.
const DEFINITION: &str = "uint32 MESSAGE_VERSION=0\nuint64 timestamp\nuint8 request_id\n";

/// A bag with requests of PX4 1.16: a timestamp, and the given ids.
fn bag(ids: &[u8]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer =
        WriteOptions::new().profile("ros2").compression(None).create(&mut bytes).expect("a writer");
    let name = "px4_msgs/msg/ArmingCheckRequest";
    let schema = writer.add_schema(name, "ros2msg", DEFINITION.as_bytes()).expect("a schema");
    let topic = "/fmu/out/arming_check_request";
    let channel = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel");
    for (sequence, id) in (3..).zip(ids) {
        let header = MessageHeader { channel_id: channel, sequence, log_time: 70, publish_time: 60 };
        let payload = [&[0, 1, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0][..], &[*id]].concat();
        writer.write_to_known_channel(&header, &payload).expect("a message");
    }
    writer.finish().expect("a summary");
    drop(writer);
    bytes.into_inner()
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.arg("convert").args(arguments).current_dir(folder).stdin(Stdio::null());
    command.output().expect("it runs")
}

/// A folder with the bag `in.mcap`.
fn workspace() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("in.mcap"), bag(&[5, 6])).expect("a file");
    folder
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// The names in a folder, including hidden files.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn messages_get_the_type_of_the_target_release() {
    let folder = workspace();
    let output = run(folder.path(), &["in.mcap", "--to", "px4@1.17", "-o", "out.mcap", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&report["from"][0], &report["to"]), (&"px4@1.16".into(), &"px4@1.17".into()));
    assert_eq!(report["topics"][0]["action"], "converted");
    assert_eq!(report["topics"][0]["messages"], 2);
    let bytes = fs::read(folder.path().join("out.mcap")).expect("a file");
    let messages: Vec<_> =
        MessageStream::new(&bytes).expect("a bag").map(|message| message.expect("a message")).collect();
    assert_eq!(messages.len(), 2);
    // The id, padding, and the mask from the published hints.
    assert_eq!(messages[1].data[12..], [6, 0, 0, 0, 255, 255, 255, 255]);
    assert_eq!((messages[1].sequence, messages[1].log_time, messages[1].publish_time), (4, 70, 60));
    let channel = &messages[0].channel;
    assert_eq!(channel.topic, "/fmu/out/arming_check_request_v1");
    let schema = channel.schema.as_ref().expect("a schema");
    assert!(text(&schema.data).contains("uint32 valid_registrations_mask"));
    let summary = mcap::Summary::read(&bytes).expect("a summary").expect("a summary");
    assert_eq!(summary.stats.expect("statistics").message_count, 2);
}

#[test]
fn hints_of_the_user_take_precedence() {
    let folder = workspace();
    let hint = "[[hint]]\nmessage = \"ArmingCheckRequest\"\nnew.valid_registrations_mask = 7\n";
    fs::write(folder.path().join("hints.toml"), hint).expect("a file");
    let output = run(folder.path(), &["in.mcap", "--to=px4@1.17", "-o=out.mcap", "--hints=hints.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let bytes = fs::read(folder.path().join("out.mcap")).expect("a file");
    let message = MessageStream::new(&bytes).expect("a bag").next().expect("a message").expect("a message");
    assert_eq!(message.data[16..], [7, 0, 0, 0]);
}

/// A log with one request of PX4 1.16. The header is followed by a format, a subscription and a message.
#[test]
fn logs_get_the_formats_of_the_target_release() {
    let folder = workspace();
    let mut log = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    let format = b"arming_check_request:uint64_t timestamp;uint8_t request_id;uint8_t[7] _padding0;";
    let messages = [(b'F', &format[..]), (b'A', b"\0\x05\0arming_check_request")];
    for (kind, payload) in messages.into_iter().chain([(b'D', &b"\x05\0\x09\0\0\0\0\0\0\0\x06"[..])]) {
        log.extend(u16::try_from(payload.len()).expect("a size").to_le_bytes());
        log.push(kind);
        log.extend(payload);
    }
    fs::write(folder.path().join("in.ulg"), &log).expect("a file");
    let arguments = ["in.ulg", "--from=px4@1.16", "--to=px4@1.17", "-o=out.ulg"];
    let output = run(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let bytes = fs::read(folder.path().join("out.ulg")).expect("a file");
    let fields =
        b"uint64_t timestamp;uint32_t valid_registrations_mask;uint8_t request_id;uint8_t[3] _padding0;";
    assert!(bytes.windows(fields.len()).any(|part| part == fields), "{}", bytes.escape_ascii());
    // The timestamp, the mask from the published hints, and the id.
    assert!(
        bytes.ends_with(b"\x0f\0D\x05\0\x09\0\0\0\0\0\0\0\xff\xff\xff\xff\x06"),
        "{}",
        bytes.escape_ascii()
    );
    fs::write(folder.path().join("cut.ulg"), &log[..log.len() - 1]).expect("a file");
    let output = run(folder.path(), &["cut.ulg", "--from=px4@1.16", "--to=px4@1.17", "-o=cut.out"]);
    assert_eq!(output.status.code(), Some(6));
    assert!(text(&output.stdout).contains("the log is truncated"), "{}", text(&output.stdout));
    assert_eq!(fs::read(folder.path().join("cut.out")).expect("a file")[..], bytes[..bytes.len() - 18]);
}

#[test]
fn the_name_of_the_output_decides_its_format() {
    let folder = workspace();
    let output = run(folder.path(), &["in.mcap", "-o", "out.ULG"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let expected = "in.mcap: px4@1.16, MCAP to ULog\n  converted  /fmu/out/arming_check_request as \
                    arming_check_request: 2 messages\n1 topic converted, 0 copied unchanged, 0 left out\n";
    assert_eq!(text(&output.stdout), expected);
    let output = run(folder.path(), &["out.ULG", "--to=px4@1.17", "-o", "out.mcap", "--format=json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&report["from_format"], &report["to_format"]), (&"ULog".into(), &"MCAP".into()));
    let bytes = fs::read(folder.path().join("out.mcap")).expect("a file");
    let messages = MessageStream::new(&bytes).expect("a bag");
    let topics: Vec<String> =
        messages.map(|message| message.expect("a message").channel.topic.clone()).collect();
    assert_eq!(topics, ["/fmu/out/arming_check_request_v1"; 2]);
    for (output, code, problem) in [
        ("same.mcap", 2, "IN and OUT are both MCAP"),
        ("same", 2, "choose another format, such as `-o out.db3`"),
    ] {
        let output = run(folder.path(), &["in.mcap", "-o", output]);
        assert_eq!(output.status.code(), Some(code));
        assert!(text(&output.stderr).contains(problem), "{}", text(&output.stderr));
    }
}

#[test]
fn json_messages_are_converted() {
    let folder = workspace();
    let line =
        r#"{"type": "px4/ArmingCheckRequest", "message": {"timestamp": 9, "request_id": 6}, "line": 1}"#;
    fs::write(folder.path().join("in.jsonl"), line).expect("a file");
    let output = run(folder.path(), &["in.jsonl", "--from=px4@1.16", "--to=px4@1.17", "-o=out.jsonl"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let converted = fs::read_to_string(folder.path().join("out.jsonl")).expect("a file");
    let message = r#"{"timestamp":9,"request_id":6,"valid_registrations_mask":4294967295}"#;
    assert_eq!(
        converted,
        format!("{{\"type\": \"px4/ArmingCheckRequest\", \"message\": {message}, \"line\": 1}}\n")
    );
}

#[test]
fn invalid_usage_leaves_no_output() {
    let folder = workspace();
    let path = folder.path();
    fs::write(path.join("wrong.toml"), "[[hint]]\nmessage = \"ArmingCheckRequest\"\nnew.winch = 7\n")
        .expect("a file");
    fs::write(path.join("bag.db3"), b"SQLite format 3\0").expect("a file");
    fs::write(path.join("text"), [1, 2, 3, 4]).expect("a file");
    fs::create_dir(path.join("folder")).expect("a folder");
    let before = names(path);
    for (arguments, status, wanted) in [
        (&["in.mcap", "--to=px4@1.2", "-o=out.mcap"][..], 2, "unknown release `px4@1.2`"),
        (&["in.mcap", "--to=px4@1.17", "--from=px5@1", "-o=out.mcap"], 2, "unknown release `px5@1`"),
        (&["in.mcap", "--to=px4@1.17", "--hints=wrong.toml", "-o=out.mcap"], 2, "wrong.toml:3:"),
        (&["in.mcap", "--to=px4@1.17", "--hints=none.toml", "-o=out.mcap"], 2, "none.toml: "),
        (
            &["in.mcap", "--to=px4@1.17", "--hints=wrong.toml", "-o=wrong.toml"],
            2,
            "would overwrite the input",
        ),
        (&["none.mcap", "--to=px4@1.17", "-o=out.mcap"], 3, "none.mcap: "),
        (&["bag.db3", "--to=px4@1.17", "-o=out.mcap"], 3, "bag.db3: the database is unreadable"),
        (&["text", "--to=px4@1.17", "-o=out.mcap"], 3, "unknown file type"),
        (&["folder", "--to=px4@1.17", "-o=out.mcap"], 3, "a folder without a metadata.yaml"),
        (&["in.mcap", "--to=px4@1.17", "-o=none/out.mcap"], 3, "none/out.mcap: "),
    ] {
        let output = run(path, arguments);
        let printed = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {printed}");
        assert!(printed.contains(wanted), "{arguments:?}: {printed}");
        assert_eq!(names(path), before, "{arguments:?}");
    }
}

#[test]
fn the_output_never_replaces_the_input() {
    let folder = workspace();
    let before = fs::read(folder.path().join("in.mcap")).expect("a file");
    fs::hard_link(folder.path().join("in.mcap"), folder.path().join("hard.mcap")).expect("a link");
    #[cfg(unix)]
    std::os::unix::fs::symlink("in.mcap", folder.path().join("soft.mcap")).expect("a link");
    let soft: &[&str] = if cfg!(unix) { &["soft.mcap"] } else { &[] };
    for output in ["in.mcap", "./in.mcap", "hard.mcap"].iter().chain(soft) {
        let result = run(folder.path(), &["in.mcap", "--to=px4@1.17", "-o", output]);
        assert_eq!(result.status.code(), Some(2), "{output}");
        assert!(text(&result.stderr).contains("would overwrite the input"), "{output}");
    }
    assert_eq!(fs::read(folder.path().join("in.mcap")).expect("a file"), before);
}

#[test]
fn a_truncated_bag_is_converted_as_far_as_possible() {
    let folder = workspace();
    let bytes = bag(&[5; 100]);
    fs::write(folder.path().join("in.mcap"), &bytes[..bytes.len() / 3]).expect("a file");
    let output = run(folder.path(), &["in.mcap", "--to=px4@1.17", "-o=out.mcap"]);
    assert_eq!(output.status.code(), Some(6), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("truncated"), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("incomplete"), "{}", text(&output.stderr));
    let bytes = fs::read(folder.path().join("out.mcap")).expect("a file");
    let count = MessageStream::new(&bytes).expect("a bag").flatten().count();
    assert!((1..100).contains(&count), "{count}");
}

#[test]
fn unreadable_messages_are_counted() {
    let folder = workspace();
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WriteOptions::new().compression(None).create(&mut bytes).expect("a writer");
    let name = "px4_msgs/msg/ArmingCheckRequest";
    let schema = writer.add_schema(name, "ros2msg", DEFINITION.as_bytes()).expect("a schema");
    let channel = writer.add_channel(schema, "/request", "cdr", &BTreeMap::new()).expect("a channel");
    let header = MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &[0, 1, 0, 0, 9]).expect("a message");
    writer.finish().expect("a summary");
    drop(writer);
    fs::write(folder.path().join("in.mcap"), bytes.into_inner()).expect("a file");
    let output = run(folder.path(), &["in.mcap", "--to=px4@1.17", "-o=out.mcap"]);
    assert_eq!(output.status.code(), Some(6), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("1 unreadable message left out"), "{}", text(&output.stdout));
}

#[test]
fn folders_become_folders_or_files() {
    let folder = workspace();
    let path = folder.path();
    fs::create_dir(path.join("bag")).expect("a folder");
    let first = run(path, &["in.mcap", "-o=bag/in.db3"]);
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert!(text(&first.stdout).contains("publish times and sequence numbers (2): they are left out"));
    let metadata = "rosbag2_bagfile_information:\n  version: 4\n  storage_identifier: sqlite3\n  \
                    relative_file_paths:\n    - in.db3\n";
    fs::write(path.join("bag/metadata.yaml"), metadata).expect("a file");
    for (arguments, status, wanted) in [
        (&["bag", "--to=px4@1.17", "-o=new"][..], 0, "1 topic converted"),
        (&["bag", "--to=px4@1.17", "-o=new"], 3, "new: it already exists"),
        (&["bag/metadata.yaml", "--to=px4@1.17", "-o=other"], 0, "1 topic converted"),
        (&["bag", "-o=out.mcap"], 0, "SQLite to MCAP"),
        (&["bag", "-o=out.ulg"], 3, "convert each of its files"),
        (&["bag", "-o=missing"], 2, "IN and OUT are both folders"),
        (&["bag", "--to=bag/metadata.yaml", "-o=missing"], 2, ""),
    ] {
        let output = run(path, arguments);
        let printed = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {printed}");
        assert!(printed.contains(wanted), "{arguments:?}: {printed}");
    }
    assert_eq!(names(path), ["bag", "in.mcap", "new", "other", "out.mcap"]);
    assert_eq!(names(&path.join("other")), ["metadata.yaml", "other_0.db3"]);
}
