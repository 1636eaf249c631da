//! Tests of MCAP files: each rule finds its violations in any kind of file, and reading continues after corruption.

mod corruption;
mod schemas;
mod suite;
mod varying;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs;
use std::io::Cursor;
use std::sync::{Arc, LazyLock};

use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use serde_json::{Value, json};
use uavspec_check::{Basis, CaptureResult, CheckStatus, McapSummary, Summary, check_capture};
use uavspec_model::{Group, Location, Verdict};
use uavspec_px4::comparison::Comparison;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::{RULES, rule};
use uavspec_schema::fingerprint::ros_name;
use uavspec_test_captures::mcap::{FORMS, Form, channel, chunked, file, message, message_at, schema};

const GLIDER: &str = "\
uint32 MESSAGE_VERSION = 2
uint8 ORB_QUEUE_LENGTH = 2

uint64 timestamp          # [us] Time since system start
float32 speed             # [m/s] [@range 0, 60] [@invalid -1] Speed
float32[2] flaps          # [rad] [@range -1, 1] [@invalid NaN] Left and right
uint8 MODE_CRUISE = 0     # Straight on
uint8 MODE_THERMAL = 7    # Circling in lift
uint8 mode                # [@enum MODE] What it does
uint8 num_marks           # [-] [@count marks] Entries of marks in use
Mark[3] marks             # Places to fly to
char[4] name              # Call sign
bool is_landed            # Whether it stands on the ground
";
const MARK: &str =
    "# A place\n\nuint64 timestamp  # [us] Time of entry\nint16 height  # [m] [@range -500, 9000] Height\n";

/// The period of the messages, in µs.
const PERIOD: u64 = 20_000;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("Glider.msg"), GLIDER).expect("a file");
    fs::write(folder.path().join("Mark.msg"), MARK).expect("a file");
    Definitions::load(folder.path()).expect("definitions")
});

/// The name and hash of a message in ROS 2.
fn ros(name: &str) -> (String, String) {
    let schema = &DEFINITIONS.schema;
    let message = schema.messages.iter().find(|message| message.name == name).expect("a message");
    (ros_name(schema, message), message.type_hash.clone())
}

/// The schema of a type with its nested types, as `rosbag2` writes it.
fn ros2msg(glider: &str) -> String {
    let package = ros("Mark").0.replace("/msg/Mark", "");
    format!("{glider}\n{}\nMSG: {package}/Mark\n{MARK}", "=".repeat(80))
}

/// A glider message that conforms.
#[derive(Clone)]
struct Glider {
    timestamp: u64,
    speed: f32,
    flaps: [f32; 2],
    mode: u8,
    num_marks: u8,
    heights: [i16; 3],
    name: [u8; 4],
    is_landed: u8,
}

impl Glider {
    fn at(timestamp: u64) -> Self {
        Self {
            timestamp,
            speed: 20.0,
            flaps: [0.5, f32::NAN],
            mode: 7,
            num_marks: 3,
            heights: [9000; 3],
            name: *b"D-1\0",
            is_landed: 1,
        }
    }

    /// The message as little-endian CDR.
    fn cdr(&self) -> Vec<u8> {
        let mut body = self.timestamp.to_le_bytes().to_vec();
        body.extend(self.speed.to_le_bytes());
        body.extend(self.flaps.iter().flat_map(|flap| flap.to_le_bytes()));
        body.extend([self.mode, self.num_marks]);
        for height in self.heights {
            body.resize(body.len().next_multiple_of(8), 0);
            body.extend([0; 8]);
            body.extend(height.to_le_bytes());
        }
        body.extend(self.name);
        body.push(self.is_landed);
        body.resize(body.len().next_multiple_of(4), 0);
        [&[0, 1, 0, 0][..], &body].concat()
    }

    /// The message as big-endian CDR.
    fn big_cdr(&self) -> Vec<u8> {
        let mut body = self.timestamp.to_be_bytes().to_vec();
        body.extend(self.speed.to_be_bytes());
        body.extend(self.flaps.iter().flat_map(|flap| flap.to_be_bytes()));
        body.extend([self.mode, self.num_marks]);
        for height in self.heights {
            body.resize(body.len().next_multiple_of(8), 0);
            body.extend([0; 8]);
            body.extend(height.to_be_bytes());
        }
        body.extend(self.name);
        body.push(self.is_landed);
        [&[0; 4][..], &body].concat()
    }

    fn json(&self) -> Value {
        let marks = self.heights.map(|height| json!({"timestamp": 0, "height": height}));
        json!({
            "timestamp": self.timestamp, "speed": self.speed, "flaps": [0.5, null], "mode": self.mode,
            "num_marks": self.num_marks, "marks": marks, "name": "D-1", "is_landed": true,
        })
    }
}

/// The channel of the glider with its schema and hash.
fn declarations() -> Vec<u8> {
    declarations_of(3)
}

/// The declaration of the glider's channel with this id.
fn declarations_of(id: u16) -> Vec<u8> {
    let (name, hash) = ros("Glider");
    let metadata = [("offered_qos_profiles", "- history: 3"), ("topic_type_hash", hash.as_str())];
    [
        schema(1, &name, "ros2msg", ros2msg(GLIDER).as_bytes()),
        channel(id, 1, "/fmu/out/glider", "cdr", &metadata),
    ]
    .concat()
}

/// The records for sixty messages in two chunks. The last message has the payload `last`.
fn records_with(last: &[u8]) -> [Vec<u8>; 2] {
    let messages = |numbers: std::ops::Range<u64>| -> Vec<u8> {
        numbers.flat_map(|number| message(3, &Glider::at(number * PERIOD).cdr())).collect()
    };
    [[declarations(), messages(1..30)].concat(), [messages(30..60), message(3, last)].concat()]
}

fn equal() -> Basis {
    Basis::Compared(Arc::new(Comparison::Equal))
}

fn good() -> Glider {
    Glider::at(60 * PERIOD)
}

fn checked(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &DEFINITIONS).expect("bytes can be read")
}

fn source(result: &CaptureResult) -> &McapSummary {
    match &result.summary {
        Summary::Mcap(source) => source,
        other => panic!("expected MCAP, found {other:?}"),
    }
}

/// The violated rules, each with the subject and message of the first finding.
fn violated(result: &CaptureResult) -> Vec<(&'static str, String)> {
    let message = |group: &Group| (group.rule.id, format!("{}: {}", group.subject, group.examples[0].1));
    result.findings.groups().map(message).collect()
}

fn corrupt_count(result: &CaptureResult) -> Vec<String> {
    result.corruption.iter().map(|(location, what)| format!("{location}: {what}")).collect()
}

/// Asserts that a file has no findings or corruption, and that all of its sixty messages are checked.
fn assert_conforms(result: &CaptureResult, what: &dyn std::fmt::Debug) {
    assert_eq!((violated(result), corrupt_count(result)), (vec![], vec![]), "{what:?}");
    assert_eq!((result.records, result.checked, result.duration), (60, 60, 59 * PERIOD), "{what:?}");
    let channels = &source(result).channels;
    assert_eq!(channels.len(), 1, "{what:?}");
    assert_eq!(channels[0].status, CheckStatus::Checked(equal()), "{what:?}");
}

#[test]
fn conforming_files_have_no_findings_in_any_form() {
    for form in FORMS {
        for last in [good().cdr(), good().big_cdr()] {
            let result = checked(&file(&chunked(form, &records_with(&last))));
            assert_conforms(&result, &form);
            let found = source(&result);
            assert_eq!((found.profile.as_str(), found.library.as_str()), ("ros2", "glider club"));
            let channel = &found.channels[0];
            assert_eq!((channel.topic.as_str(), channel.encoding.as_str()), ("/fmu/out/glider", "cdr"));
            assert_eq!(channel.messages, 60);
        }
    }
    let result = checked(&file(&chunked(Form::Plain, &records_with(&good().cdr()))));
    let idle: Vec<&str> = RULES
        .iter()
        .filter(|rule| !rule.is_on_flockwave())
        .filter(|rule| result.findings.verdict(rule) == Verdict::NotCovered)
        .map(|rule| rule.id)
        .collect();
    // There are no events, no external component communicates, the topic has no version suffix, and the file is neither a log nor JSON.
    let data = ["PX-ARR-01", "PX-DATA-01", "PX-DATA-02", "PX-DATA-03"];
    let ids = RULES.iter().map(|rule| rule.id);
    let talk: Vec<&str> = ids.filter(|id| id.starts_with("PX-EVT-") || id.starts_with("PX-EXT-")).collect();
    let others = ["PX-FMT-02", "PX-FSF-03", "PX-HASH-02", "PX-JSON-01", "PX-JSON-02"];
    // The file contains no publishers and subscribers.
    let live = ["PX-QOS-01", "PX-TYPE-01", "PX-VER-01"];
    assert_eq!(idle, [&data[..], &talk, &others, &live].concat());
}

/// A file written by the `mcap` crate, with indices, checksums and a summary.
fn other_writers_file(use_chunks: bool, disable_seeking: bool, has_checksum: bool) -> Vec<u8> {
    let (name, _) = ros("Glider");
    let options = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(1_000))
        .calculate_data_section_crc(has_checksum)
        .use_chunks(use_chunks)
        .disable_seeking(disable_seeking);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    let schema = Arc::new(mcap::Schema {
        id: 1,
        name: name.clone(),
        encoding: "ros2msg".to_owned(),
        data: Cow::Owned(ros2msg(GLIDER).into_bytes()),
    });
    let channel = Arc::new(mcap::Channel {
        id: 0,
        topic: "/fmu/out/glider".to_owned(),
        schema: Some(schema),
        message_encoding: "cdr".to_owned(),
        metadata: [("topic_type_hash".to_owned(), ros("Glider").1)].into(),
    });
    for number in 1..=60 {
        let message = mcap::Message {
            channel: channel.clone(),
            sequence: 0,
            log_time: number,
            publish_time: number,
            data: Cow::Owned(Glider::at(number * PERIOD).cdr()),
        };
        writer.write(&message).expect("memory");
    }
    let attachment = mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: "picture".to_owned(),
        media_type: "image/png".to_owned(),
        data: Cow::Owned(vec![5; 100_000]),
    };
    writer.attach(&attachment).expect("memory");
    let metadata = mcap::records::Metadata {
        name: "club".to_owned(),
        metadata: [("field".to_owned(), "grass".to_owned())].into(),
    };
    writer.write_metadata(&metadata).expect("memory");
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

#[test]
fn checks_files_of_another_writer() {
    for (use_chunks, disable_seeking) in [(true, false), (true, true), (false, false)] {
        let bytes = other_writers_file(use_chunks, disable_seeking, true);
        assert_conforms(&checked(&bytes), &(use_chunks, disable_seeking));
    }
}

/// A copy of a file in which additional bytes follow all records except messages. Also returns the kinds of the
/// extended records.
fn extended(bytes: &[u8]) -> (Vec<u8>, BTreeSet<u8>) {
    let (mut longer, mut kinds, mut at) = (
        uavspec_test_captures::mcap::MAGIC.to_vec(),
        BTreeSet::new(),
        uavspec_test_captures::mcap::MAGIC.len(),
    );
    while at + uavspec_test_captures::mcap::MAGIC.len() < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("8 bytes"));
        let end = at + 9 + usize::try_from(length).expect("a length");
        let added = if bytes[at] == mcap::records::op::MESSAGE { &b""[..] } else { b"of a later version" };
        if !added.is_empty() {
            kinds.insert(bytes[at]);
        }
        longer.extend(uavspec_test_captures::mcap::record(bytes[at], &[&bytes[at + 9..end], added]));
        at = end;
    }
    longer.extend(uavspec_test_captures::mcap::MAGIC);
    (longer, kinds)
}

/// The MCAP specification requires readers to ignore unknown fields at the end of a record.
#[test]
fn ignores_unknown_fields_at_the_end_of_records() {
    use mcap::records::op;

    let mut extended_kinds = BTreeSet::new();
    for use_chunks in [true, false] {
        let (bytes, kinds) = extended(&other_writers_file(use_chunks, false, false));
        extended_kinds.extend(kinds);
        let mut result = checked(&bytes);
        // The checksum, the start and the indexes in the summary come from the original file.
        result
            .corruption
            .retain(|(_, text)| !text.contains("summary") && !text.contains("the index doesn't"));
        assert_conforms(&result, &use_chunks);
    }
    let packed = [
        uavspec_test_captures::mcap::start(),
        chunked(Form::Zstd, &records_with(&good().cdr())),
        uavspec_test_captures::mcap::end(),
    ]
    .concat();
    assert_conforms(&checked(&extended(&packed).0), &"a compressed chunk");
    let all_kinds = (op::HEADER..=op::DATA_END).filter(|kind| *kind != op::MESSAGE).collect();
    assert_eq!(extended_kinds, all_kinds);
}

/// A file with a JSON channel and these messages.
fn json_file(topic: &str, messages: &[Value]) -> Vec<u8> {
    let (name, _) = ros("Glider");
    let mut records = [schema(1, &name, "jsonschema", b"{}"), channel(3, 1, topic, "json", &[])].concat();
    records.extend(messages.iter().flat_map(|value| message(3, value.to_string().as_bytes())));
    file(&records)
}

fn json_with(change: impl Fn(&mut Value)) -> Vec<u8> {
    let mut messages: Vec<Value> = (1..=60).map(|number| Glider::at(number * PERIOD).json()).collect();
    change(&mut messages[59]);
    json_file("/glider", &messages)
}

/// Files that violate one rule each, with the expected message.
fn mutants() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let with_payload = |payload: &[u8]| file(&chunked(Form::Plain, &records_with(payload)));
    let value = |change: fn(&mut Glider)| {
        let mut glider = good();
        change(&mut glider);
        with_payload(&glider.cdr())
    };
    let changed = |from: &str, to: &str| {
        let (name, _) = ros("Glider");
        let text = ros2msg(&GLIDER.replace(from, to));
        assert_ne!(text, ros2msg(GLIDER));
        file(&[schema(1, &name, "ros2msg", text.as_bytes()), channel(3, 1, "/glider", "cdr", &[])].concat())
    };
    let mut header = good().cdr();
    header[1] = 0x20;
    let mut long = good().cdr();
    long.extend([0; 4]);
    let early = Glider { timestamp: 58 * PERIOD, ..good() };
    let burst: Vec<u8> = (0..3).flat_map(|_| message(3, &good().cdr())).collect();
    let other_hash =
        channel(3, 0, "/glider", "cdr", &[("topic_type_hash", &format!("RIHS01_{}", "0".repeat(64)))]);
    vec![
        (
            "PX-ARR-01",
            json_with(|json| json["flaps"] = json!([0.5])),
            "/glider.flaps: expected 2 elements, found 1",
        ),
        (
            "PX-BOOL-01",
            value(|glider| glider.is_landed = 153),
            "/glider.is_landed: expected 0 or 1, found 153",
        ),
        (
            "PX-CDR-01",
            with_payload(&header),
            "/glider: expected 00 01 (little endian) or 00 00 (big endian), found 00 20",
        ),
        (
            "PX-CDR-02",
            with_payload(&good().cdr()[..70]),
            "/glider: name[0] at byte 70: expected 4 more bytes, found 0",
        ),
        ("PX-CDR-02", with_payload(&long), "/glider: Glider at byte 75: "),
        ("PX-CDR-02", with_payload(&[0, 1]), "/glider: expected a header of 4 bytes, found 2"),
        ("PX-ENUM-01", value(|glider| glider.mode = 8), "/glider.mode: "),
        (
            "PX-FMT-01",
            changed("uint8 mode ", "uint8 kind "),
            "/glider: missing fields: mode (uint8); additional fields: kind (uint8)",
        ),
        ("PX-HASH-01", file(&other_hash), "/glider: expected RIHS01_"),
        ("PX-JSON-01", json_with(|json| json["depth"] = json!(1)), "/glider.depth: Glider has no such field"),
        ("PX-JSON-02", json_with(|json| json["mode"] = json!("far")), "/glider.mode: expected an integer"),
        (
            "PX-LEN-01",
            value(|glider| glider.num_marks = 4),
            "/glider.num_marks: 4 exceeds the array length 3",
        ),
        ("PX-NAN-01", value(|glider| glider.speed = f32::NAN), "/glider.speed: NaN is not allowed here"),
        (
            "PX-QUEUE-01",
            file(&[declarations(), burst].concat()),
            "/glider: more than 2 messages with timestamp 1200000 µs",
        ),
        (
            "PX-RANGE-01",
            value(|glider| glider.heights[1] = 9001),
            "/glider.marks.height: marks[1].height: 9001 is out",
        ),
        ("PX-STR-01", value(|glider| glider.name = *b"D\xff\0\0"), "/glider.name: invalid UTF-8 at byte 1"),
        (
            "PX-TIME-01",
            file(&[records_with(&early.cdr()).concat(), message(3, &Glider::at(61 * PERIOD).cdr())].concat()),
            "/glider.timestamp: timestamp 1160000",
        ),
        ("PX-TIME-02", value(|glider| glider.timestamp = 80 * PERIOD), "/glider: no message for 420 ms"),
        (
            "PX-VER-01",
            json_file("/fmu/out/glider_v1", &[good().json()]),
            "/glider_v1: the topic name has version 1, but the definition has version 2",
        ),
    ]
}

#[test]
fn a_violation_has_a_message_and_a_location() {
    let mutants = mutants();
    for (id, bytes, message) in mutants {
        let result = checked(&bytes);
        let found = violated(&result);
        assert!(
            found.len() == 1
                && found[0].0 == id
                && found[0].1.trim_start_matches("/fmu/out").starts_with(message),
            "{id}: {found:#?}"
        );
        assert_eq!(corrupt_count(&result), Vec::<String>::new(), "{id}");
    }
}

/// Checks messages. The pairs are the recording times and the timestamps, in periods. Returns the violated rules, and
/// how often the two rules on times were covered.
fn check_times(times: impl IntoIterator<Item = (u64, u64)>) -> (Vec<&'static str>, [u64; 2]) {
    let logged = |time: u64| 1_000 * (1_000_000 + time * PERIOD);
    let messages = times
        .into_iter()
        .flat_map(|(recorded, time)| message_at(3, logged(recorded), &Glider::at(time * PERIOD).cdr()));
    let records: Vec<u8> = declarations().into_iter().chain(messages).collect();
    let result = checked(&file(&records));
    let covered = ["PX-TIME-01", "PX-TIME-02"].map(|id| result.findings.covered(rule(id).expect("a rule")));
    (violated(&result).into_iter().map(|(id, _)| id).collect(), covered)
}

#[test]
fn log_times_tell_an_early_message_from_a_clock_that_was_set_back() {
    let regular = || (1..=10).map(|number| (number, number));
    assert_eq!(check_times(regular().chain([(11, 9), (12, 12)])).0, ["PX-TIME-01"]);
    // The topic pauses after the clock was set back.
    assert_eq!(check_times(regular().chain([(11, 9), (16, 14), (17, 15)])), (vec![], [12, 0]));
}

/// MCAP allows messages in any order.
#[test]
fn messages_that_are_not_in_the_order_of_their_log_times_are_not_compared() {
    let regular = |numbers: std::ops::RangeInclusive<u64>| numbers.map(|number| (number, number));
    let start = || regular(1..=40).chain(regular(61..=80));
    assert_eq!(check_times(start()).0, ["PX-TIME-02"]);
    assert_eq!(check_times(start().chain(regular(41..=60))), (vec![], [78, 0]));
    assert_eq!(check_times(regular(1..=8).chain([(10, 10), (9, 9), (11, 11)])), (vec![], [9, 0]));
}

/// The findings of another channel remain. Both channels have the same topic if their namespaces are ignored.
#[test]
fn only_the_findings_of_a_channel_without_order_are_removed() {
    let (_, hash) = ros("Glider");
    let second = channel(4, 1, "/left/fmu/out/glider", "cdr", &[("topic_type_hash", hash.as_str())]);
    let of = |channel: u16, number: u64| {
        message_at(channel, 1_000 * (1_000_000 + number * PERIOD), &Glider::at(number * PERIOD).cdr())
    };
    let paused = (1..=40).chain(61..=80).flat_map(|number| [of(3, number), of(4, number)].concat());
    let late = (50..=55).flat_map(|number| of(3, number));
    let records: Vec<u8> = declarations().into_iter().chain(second).chain(paused).chain(late).collect();
    let result = checked(&file(&records));
    let counts: Vec<u64> = result.findings.groups().map(|group| group.count).collect();
    assert_eq!((violated(&result).len(), counts), (1, vec![1]));
}

#[test]
fn conforming_json_has_no_findings() {
    let result = checked(&json_with(|_| ()));
    assert_eq!((violated(&result), corrupt_count(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked, result.duration), (60, 60, 59 * PERIOD));
    assert_eq!(source(&result).channels[0].status, CheckStatus::Checked(Basis::NoSchema));
}

/// rosbag2 can compress each message separately without indicating this in the file.
#[test]
fn unpacks_separately_compressed_messages() {
    let pack = |payload: &[u8]| compress_to_vec(payload, CompressionLevel::Fastest);
    let odd = Glider { is_landed: 3, ..good() };
    let packed = pack(&good().cdr());
    // Blocks of 128 KiB, each of which repeats one byte (RFC 8878).
    let block = ((128_u32 << 10) << 3 | 1 << 1).to_le_bytes();
    let bomb =
        [&[0x28, 0xb5, 0x2f, 0xfd, 0, 0x38][..], &[block[0], block[1], block[2], 7].repeat(600)].concat();
    let records = [
        declarations(),
        message(3, &packed),
        message(3, &pack(&odd.cdr())),
        message(3, &packed[..20]),
        message(3, &bomb),
    ];
    let result = checked(&file(&records.concat()));
    let expected = [("PX-BOOL-01", "/fmu/out/glider.is_landed: expected 0 or 1, found 3".to_owned())];
    assert_eq!((violated(&result), result.checked), (expected.to_vec(), 2));
    let message = corrupt_count(&result);
    assert!(message.len() == 2 && message[0].contains("can't be decompressed: "), "{message:?}");
    assert!(message[1].ends_with("the compressed message has more than 67108864 bytes"), "{message:?}");
}

/// Foxglove writes bytes as base64. Invalid JSON counts as corruption, and so does JSON that is nested too deeply.
#[test]
fn reads_json_dialects_and_reports_corrupt_json() {
    let (name, _) = ros("Glider");
    let mut numbers = good().json();
    numbers["name"] = json!([68, 45, 49, 0]);
    let deep = ["timestamp", "name", "unknown"]
        .map(|key| format!("{{\"{key}\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000)));
    let records = [
        schema(1, &name, "jsonschema", b"{}"),
        channel(3, 1, "/glider", "json", &[]),
        message(3, numbers.to_string().as_bytes()),
        message(3, b"{\"timestamp\": "),
        message(3, b"\xff"),
        message(3, b""),
        message(3, deep[0].as_bytes()),
        message(3, deep[1].as_bytes()),
        message(3, deep[2].as_bytes()),
    ];
    let result = checked(&file(&records.concat()));
    assert_eq!((violated(&result), result.records, result.checked), (vec![], 7, 1));
    assert_eq!(corrupt_count(&result).len(), 6, "{:?}", result.corruption);
    let dialects: Vec<String> = source(&result).dialects.iter().map(|dialect| dialect.to_string()).collect();
    assert_eq!(dialects, ["numbers for char[N] (ROS 2)"]);
}

/// No type can have a malformed hash, so it is also reported for types without a definition.
#[test]
fn reports_malformed_type_hashes_of_all_types() {
    let (name, hash) = ros("Glider");
    let digits = "0".repeat(63);
    for (hash, expected) in [
        (hash.clone(), vec![]),
        (hash.to_ascii_uppercase(), vec![]),
        (String::new(), vec![]),
        ("RIHS02_any".to_owned(), vec![]),
        (format!("RIHS01_{digits}"), vec!["/glider", "/wind"]),
        (format!("RIHS01_{digits}g"), vec!["/glider", "/wind"]),
        (format!("RIHS01_{digits}00"), vec!["/glider", "/wind"]),
        ("RIHS01_".to_owned(), vec!["/glider", "/wind"]),
        ("md5:0123".to_owned(), vec!["/glider", "/wind"]),
        ("é".repeat(10_000), vec!["/glider", "/wind"]),
    ] {
        let hashes = [("topic_type_hash", hash.as_str())];
        let records = [
            schema(1, &name, "ros2msg", ros2msg(GLIDER).as_bytes()),
            schema(2, "air_msgs/msg/Wind", "ros2idl", b"struct Wind { float speed; };\n"),
            channel(1, 1, "/glider", "cdr", &hashes),
            channel(2, 2, "/wind", "cdr", &hashes),
        ];
        let result = checked(&file(&records.concat()));
        let found: Vec<_> = result.findings.groups().map(|group| (group.rule.id, &*group.subject)).collect();
        let expected: Vec<_> = expected.into_iter().map(|subject| ("PX-HASH-01", subject)).collect();
        assert_eq!(found, expected, "{hash:.100}");
        for group in result.findings.groups() {
            assert!(
                group.examples[0].1.message.starts_with("expected RIHS01_ and 64 hexadecimal digits, found ")
            );
            assert!(group.examples[0].1.message.len() < 300);
        }
    }
}

#[test]
fn findings_name_the_log_time_and_the_sequence() {
    let odd = Glider { is_landed: 3, ..good() };
    let payload = odd.cdr();
    let body = [
        &3_u16.to_le_bytes()[..],
        &9_u32.to_le_bytes(),
        &1_790_000_000_592_000_001_u64.to_le_bytes(),
        &[0; 8],
    ];
    let records = [
        declarations(),
        message(3, &Glider::at(PERIOD).cdr()),
        uavspec_test_captures::mcap::record(5, &[&body.concat(), &payload]),
    ];
    for form in FORMS {
        let result = checked(&file(&chunked(form, &[records.concat()])));
        let group = result.findings.groups().next().expect("a finding");
        let (location, detail) = &group.examples[0];
        assert_eq!(
            (detail.log_time, detail.sequence),
            (Some(1_790_000_000_592_000_001), Some(9)),
            "{form:?}"
        );
        let is_packed = matches!(form, Form::Zstd | Form::Lz4);
        assert_eq!(*location == Location::Message(2), is_packed, "{form:?}: {location}");
    }
    let different = ros2msg(&GLIDER.replace("uint8 mode ", "uint8 kind "));
    let records =
        [schema(1, &ros("Glider").0, "ros2msg", different.as_bytes()), channel(3, 1, "/glider", "cdr", &[])];
    let result = checked(&file(&chunked(Form::Zstd, &[records.concat()])));
    let group = result.findings.groups().next().expect("a finding");
    assert_eq!((group.rule.id, group.examples[0].0), ("PX-FMT-01", Location::Channel(3)));
}

#[test]
fn unchecked_channels_have_a_reason() {
    let records = [
        schema(1, "std_msgs/msg/String", "ros2msg", b"string data\n"),
        schema(2, "Glider", "protobuf", b"\0\x01"),
        channel(1, 1, "/glider", "cdr", &[]),
        channel(2, 2, "/club/glider", "protobuf", &[]),
        channel(3, 0, "/glider/0", "cdr", &[]),
        channel(4, 0, "/talk", "json", &[]),
        channel(5, 0, "/glider", "", &[]),
    ];
    let mut version_2 = good().cdr();
    version_2[1] = 7;
    let messages: Vec<u8> = (1..=5).flat_map(|id| message(id, &version_2)).collect();
    let result = checked(&file(&[records.concat(), messages].concat()));
    assert_eq!((violated(&result), corrupt_count(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (5, 0));
    let found: Vec<_> = source(&result)
        .channels
        .iter()
        .map(|channel| (channel.topic.as_str(), channel.status.clone(), channel.other_cdr))
        .collect();
    let expected = [
        ("/club/glider", CheckStatus::Unsupported, 0),
        ("/glider", CheckStatus::OwnSchema, 1),
        ("/glider", CheckStatus::Unsupported, 0),
        ("/glider/0", CheckStatus::Checked(Basis::NoSchema), 1),
        ("/talk", CheckStatus::Undefined, 0),
    ];
    assert_eq!(found, expected);
}
