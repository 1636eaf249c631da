//! Tests of the messages of a topic as a table.

use std::fs;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float32Type, UInt8Type};
use tempfile::TempDir;
use uavspec_rules::definitions::Definitions;
use uavspec_tables::{Capture, Checker, Messages, Options, Problem};
use uavspec_test_captures::mcap::{self as file, channel, message, schema};

const GLIDER: &str = "\
uint64 timestamp                         # [us] Time since system start
uint64 capture_time                      # [-] Number of the photo
float32 speed                            # [m/s] [@range 0, 60] Speed
uint64 MODE_SLOW = 1                     # Slow
uint64 MODE_FAST = 18446744073709551615  # Fast
uint64 mode                              # [@enum MODE] Mode
";

const NOTE: &str = "string text\nuint8[] marks\n";

/// Reads the gliders of a capture.
fn gliders(bytes: Vec<u8>) -> Messages {
    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("Glider.msg"), GLIDER).expect("a file");
    let options = Options { definitions: Some(folder.path().to_owned()), ..Options::default() };
    read(&options, bytes, "/glider").expect("a topic")
}

/// Reads a topic of a capture.
fn read(options: &Options, bytes: Vec<u8>, topic: &str) -> Result<Messages, Problem> {
    let capture = Capture::Bytes { name: "flight".to_owned(), bytes: bytes.into() };
    Checker::new(options).expect("definitions").read(&capture, topic, 0)
}

/// A glider message with this speed.
fn glider(speed: &str) -> String {
    format!(r#"{{"timestamp": 9, "capture_time": 1, "speed": {speed}, "mode": 1}}"#)
}

fn published(message: &str) -> String {
    format!(r#"{{"op": "publish", "topic": "/glider", "msg": {message}}}"#)
}

/// The speeds in a table.
fn speeds(messages: &Messages) -> Vec<String> {
    let columns = messages.batches.iter().map(|batch| batch.column_by_name("speed").expect("a column"));
    columns
        .flat_map(|column| column.as_primitive::<Float32Type>().values().iter())
        .map(f32::to_string)
        .collect()
}

#[test]
fn messages_with_findings_are_rows() {
    // The last one doesn't fit into its field.
    let sent = [glider("20.0"), glider("90.0"), glider("\"fast\"")];
    let lines: Vec<String> = sent.iter().map(|message| published(message)).collect();
    let messages = gliders(lines.join("\n").into_bytes());
    assert_eq!(speeds(&messages), ["20", "90"]);
    let records = sent.iter().flat_map(|sent| message(1, sent.as_bytes()));
    let records = channel(1, 0, "/glider", "json", &[]).into_iter().chain(records);
    let messages = gliders(file::file(&records.collect::<Vec<u8>>()));
    assert_eq!(speeds(&messages), ["20", "90"]);
}

#[test]
fn columns_have_different_names_and_state_their_facts() {
    let messages = gliders(published(&glider("20.0")).into_bytes());
    let names: Vec<&str> = messages.schema.fields().iter().map(|field| field.name().as_str()).collect();
    assert_eq!(names, ["capture_time_", "timestamp", "capture_time", "speed", "mode"]);
    let fact = |name: &str, key: &str| {
        messages.schema.field_with_name(name).expect("a column").metadata().get(key).cloned()
    };
    assert_eq!(fact("speed", "unit").as_deref(), Some("m/s"));
    assert_eq!(fact("capture_time", "unit"), None);
    let values = fact("mode", "values").expect("values");
    assert!(values.contains(":1,") || values.contains(":1}"), "{values}");
    assert!(values.contains(":18446744073709551615"), "{values}");
}

/// True if a table has a row with the expected text and the expected marks.
fn has_note(messages: &Messages) -> bool {
    messages.batches.iter().any(|batch| {
        let column = |name: &str| batch.column_by_name(name).expect("a column").clone();
        let (texts, marks) = (column("text"), column("marks"));
        let marks = marks.as_list::<i32>().value(0);
        texts.as_string::<i32>().value(0) == "hello"
            && marks.as_primitive::<UInt8Type>().values()[..] == [1, 2]
    })
}

#[test]
fn texts_and_sequences_are_read() {
    let payload = [&[0, 1, 0, 0, 6, 0, 0, 0][..], b"hello\0\0\0", &[2, 0, 0, 0, 1, 2]].concat();
    let records = [
        schema(1, "club_msgs/msg/Note", "ros2msg", NOTE.as_bytes()),
        channel(1, 1, "/note", "cdr", &[]),
        message(1, &payload),
    ];
    let messages = read(&Options::default(), file::file(&records.concat()), "/note").expect("a topic");
    assert!(has_note(&messages));

    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("Note.msg"), NOTE).expect("a file");
    let schema = Definitions::load(folder.path()).expect("definitions").schema;
    let note = schema.messages.iter().find(|message| message.name == "Note").expect("the message");
    let package = &schema.packages[note.package].name;
    let options = Options { definitions: Some(folder.path().to_owned()), ..Options::default() };
    let line = format!(r#"{{"type": "{package}/Note", "message": {{"text": "hello", "marks": [1, 2]}}}}"#);
    let lines = format!("{line}\n{line}\n").into_bytes();
    let messages = read(&options, lines, &format!("{package}/Note")).expect("a topic");
    assert_eq!(messages.batches.iter().map(RecordBatch::num_rows).sum::<usize>(), 2);
    assert!(has_note(&messages));
}

#[test]
fn messages_of_a_topic_must_have_one_type() {
    let bag = |other: &str, payload: &[u8]| {
        let records = [
            schema(1, "club_msgs/msg/Note", "ros2msg", b"uint8 id\n"),
            channel(1, 1, "/note", "cdr", &[]),
            message(1, &[0, 1, 0, 0, 7]),
            schema(2, "club_msgs/msg/Other", "ros2msg", other.as_bytes()),
            channel(2, 2, "/note", "cdr", &[]),
            message(2, payload),
        ];
        read(&Options::default(), file::file(&records.concat()), "/note")
    };
    let same = bag("uint8 id\n", &[0, 1, 0, 0, 8]).expect("a topic");
    assert_eq!(same.batches[0].num_rows(), 2);
    for (other, payload) in [("uint16 id\n", &[0, 1, 0, 0, 8, 0][..]), ("uint8 number\n", &[0, 1, 0, 0, 8])] {
        let problem = bag(other, payload).expect_err("two types");
        assert_eq!(problem.to_string(), "flight: topic `/note` has messages of several types");
    }
}

#[test]
fn large_messages_end_a_batch() {
    let text = vec![b'x'; 17_000_000];
    let length = u32::try_from(text.len() + 1).expect("a length");
    let sent = message(1, &[&[0, 1, 0, 0][..], &length.to_le_bytes(), &text, &[0]].concat());
    let start = [
        file::start(),
        schema(1, "club_msgs/msg/Note", "ros2msg", b"string text\n"),
        channel(1, 1, "/note", "cdr", &[]),
    ];
    let bytes = [&*start.concat(), &sent, &sent, &sent, &sent, &sent, &file::end()].concat();
    let messages = read(&Options::default(), bytes, "/note").expect("a topic");
    let rows: Vec<usize> = messages.batches.iter().map(RecordBatch::num_rows).collect();
    assert_eq!(rows, [4, 1]);
}
