//! Tests of conversions between logs and bags.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_capture::mcap::{Event, Reader, metadata, metadata_body};
use uavspec_capture::ulog;
use uavspec_check::convert::{Action, ConversionReport, Error, Format, Output, Plan, Settings, convert};
use uavspec_check::open_path;
use uavspec_rules::definitions::{Library, Stated};
use uavspec_rules::sample::{Entry, Log};
use uavspec_test_captures::{head_of_log, mcap};

use super::{LIBRARY, checked, release, short_flight};

/// A time in UTC, in µs.
const UTC: u64 = 1_700_000_000_000_000;

/// Converts a capture to another format.
fn changed(bytes: &[u8], format: Format, to: Option<&Library>) -> Result<(ConversionReport, Vec<u8>), Error> {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("in");
    fs::write(&path, bytes).expect("a file");
    let opened = open_path(&path, &LIBRARY, &|input| input).expect("a file").expect("a capture");
    let plan = Plan::new(opened.definitions.clone(), &LIBRARY, to, None).expect("a plan");
    let mut output = Vec::new();
    let settings = Settings { format: Some(format), ..Settings::default() };
    let report = convert((&path, opened), &plan, settings, Output::Stream(&mut output))?;
    Ok((report, output))
}

fn bag_of(log: &[u8], to: Option<&Library>) -> (ConversionReport, Bag) {
    let (report, output) = changed(log, Format::Mcap, to).expect("a conversion");
    (report, Bag::read(output))
}

/// The message of a log.
fn record(kind: u8, payload: &[u8]) -> Vec<u8> {
    let size = u16::try_from(payload.len()).expect("a size").to_le_bytes();
    [&size, &[kind][..], payload].concat()
}

/// A key with its type, and a value.
fn keyed(key: &str, value: &[u8]) -> Vec<u8> {
    [&[u8::try_from(key.len()).expect("a length")], key.as_bytes(), value].concat()
}

/// A log with these messages after the flag bits.
fn log(messages: &[(u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Log { entries: vec![Entry::FlagBits] }.to_bytes();
    bytes.extend(messages.iter().flat_map(|(kind, payload)| record(*kind, payload)));
    bytes
}

/// The format, the subscription and the data of a topic with a timestamp.
fn topic(id: u16, name: &str, fields: &str, data: &[&[u8]]) -> [Vec<(u8, Vec<u8>)>; 2] {
    let format = (b'F', format!("{name}:uint64_t timestamp;{fields}").into_bytes());
    let subscription = (b'A', [&[0], &id.to_le_bytes()[..], name.as_bytes()].concat());
    let data = data.iter().map(|data| (b'D', [&id.to_le_bytes(), *data].concat()));
    [vec![format], std::iter::once(subscription).chain(data).collect()]
}

/// The content of an MCAP file.
#[derive(Default)]
pub(super) struct Bag {
    bytes: Vec<u8>,
    /// The types by topic.
    pub(super) types: BTreeMap<String, Arc<Stated>>,
    /// The times, topics and messages.
    pub(super) messages: Vec<(u64, String, Value)>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
}

impl Bag {
    /// Reads a file. The channels have the type hashes of their schemas.
    pub(super) fn read(bytes: Vec<u8>) -> Self {
        let hash = |name: &str, text: &[u8]| {
            LIBRARY.base().shared.stated(name, text).expect("a type").type_hash.clone()
        };
        Self::read_as(bytes, hash)
    }

    /// Reads a file whose channels have these type hashes, by type.
    pub(super) fn read_with(bytes: Vec<u8>, hash: impl Fn(&str) -> String) -> Self {
        Self::read_as(bytes, |name, _| hash(name))
    }

    fn read_as(bytes: Vec<u8>, hash: impl Fn(&str, &[u8]) -> String) -> Self {
        let (mut bag, mut schemas, mut topics) = (Self::default(), BTreeMap::new(), BTreeMap::new());
        let mut reader = Reader::new(&*bytes);
        while let Some(item) = reader.next().expect("memory") {
            match item.event {
                Event::Schema { id, name, text, .. } => {
                    schemas.insert(id, (name, text.to_vec()));
                }
                Event::Channel { id, schema, topic, metadata, .. } if !topics.contains_key(&id) => {
                    let (name, text) = &schemas[&schema];
                    let definitions = LIBRARY.base();
                    let stated = definitions.shared.stated(name, text).expect("a type");
                    let stored = metadata.get("topic_type_hash").map_or("", String::as_str);
                    assert_eq!(stored, hash(name, text), "{name}");
                    bag.types.insert(topic.clone(), stated);
                    topics.insert(id, topic);
                }
                Event::Message { channel, time, payload, .. } => {
                    let topic = &topics[&channel];
                    let message = bag.types[topic].root().decode_cdr(payload).expect("a message");
                    bag.messages.push((time, topic.clone(), message.to_json().expect("JSON")));
                }
                Event::Metadata { body } => bag.metadata.extend(metadata(body)),
                Event::Problem(problem) => panic!("{problem}"),
                _ => {}
            }
        }
        Self { bytes, ..bag }
    }

    pub(super) fn messages(&self, topic: &str) -> Vec<(u64, &Value)> {
        let own = self.messages.iter().filter(|(_, known, _)| known == topic);
        own.map(|(time, _, message)| (*time, message)).collect()
    }
}

/// The messages of a log by kind, without padding in the formats. The topics of the data replace their ids.
fn content(bytes: &[u8]) -> BTreeMap<char, Vec<Vec<u8>>> {
    let (mut reader, mut topics) = (ulog::Reader::new(bytes), BTreeMap::new());
    let mut content: BTreeMap<char, Vec<Vec<u8>>> = BTreeMap::new();
    while let Some(item) = reader.next().expect("a slice") {
        let kind = char::from(item.bytes.get(2).copied().unwrap_or_default());
        let entry = match item.event {
            ulog::Event::Start { timestamp, .. } => timestamp.to_le_bytes().to_vec(),
            ulog::Event::Problem(problem) => panic!("{problem}"),
            ulog::Event::Subscription { id, name, multi_id } => {
                topics.insert(id, [name.as_bytes(), &[multi_id]].concat());
                continue;
            }
            ulog::Event::Data { id, payload } => [&topics[&id], payload].concat(),
            _ => item.bytes[3..].to_vec(),
        };
        content.entry(kind).or_default().push(entry);
    }
    for entries in content.values_mut() {
        entries.sort();
    }
    content
}

#[test]
fn a_log_becomes_a_bag_and_the_same_log_again() {
    let mut flight = short_flight("px4@1.17").clone();
    flight.messages.truncate(60);
    let bytes = {
        let mut log = flight.log();
        // PX4 writes no padding at the end.
        let sizes = flight.messages.iter().map(|sent| {
            let message = flight.message(sent).expect("a message");
            (sent.topic, message.message_type().size().expect("a size").no_padding)
        });
        let sizes: BTreeMap<usize, usize> = sizes.collect();
        for entry in &mut log.entries {
            if let Entry::Data(id, payload) = entry {
                payload.truncate(sizes[&usize::from(*id)]);
            }
        }
        let end = log.entries.iter().position(|entry| matches!(entry, Entry::Subscription(..)));
        let data = log.entries.split_off(end.expect("a subscription"));
        let used: Vec<u16> = data
            .iter()
            .filter_map(|entry| match entry {
                Entry::Data(id, _) => Some(*id),
                _ => None,
            })
            .collect();
        let data: Vec<Entry> = data
            .into_iter()
            .filter(|entry| !matches!(entry, Entry::Subscription(id, ..) if !used.contains(id)))
            .collect();
        let mut bytes = log.to_bytes();
        // The log has default parameters.
        bytes[19] = 1;
        let text = "é\nline";
        for (kind, payload) in [
            (b'I', keyed("uint32_t ver_sw_release", &[255, 1, 17, 1])),
            (b'I', keyed("float scale", &0.1_f32.to_le_bytes())),
            (b'M', [&[0][..], &keyed("char[7] notes", text.as_bytes())].concat()),
            (b'M', [&[0][..], &keyed("char[3] notes", b"two")].concat()),
            (b'P', keyed("int32_t SYS_AUTOSTART", &(-4_i32).to_le_bytes())),
            (b'P', keyed("float MPC_XY_VEL_MAX", &12.5_f32.to_le_bytes())),
            (b'P', keyed("float UNSET", &f32::NAN.to_le_bytes())),
            (b'P', keyed("float LIMIT", &f32::NEG_INFINITY.to_le_bytes())),
            (b'Q', [&[1][..], &keyed("float MPC_XY_VEL_MAX", &12_f32.to_le_bytes())].concat()),
            (b'Q', [&[2][..], &keyed("int32_t SYS_AUTOSTART", &4_i32.to_le_bytes())].concat()),
        ] {
            bytes.extend(record(kind, &payload));
        }
        bytes.extend(Log { entries: data }.to_bytes().split_off(16));
        for (kind, payload) in [
            (b'P', keyed("int32_t SYS_AUTOSTART", &5_i32.to_le_bytes())),
            (b'L', [b"4", &9_000_000_u64.to_le_bytes()[..], b"Low battery"].concat()),
            (b'C', [b"6", &7_u16.to_le_bytes()[..], &9_000_001_u64.to_le_bytes(), b"tagged"].concat()),
            (b'O', 20_u16.to_le_bytes().to_vec()),
        ] {
            bytes.extend(record(kind, &payload));
        }
        bytes
    };
    let (report, bag) = bag_of(&bytes, None);
    assert!(report.is_complete() && report.count(Action::LeftOut) == 0, "{}", report.to_text());
    assert_eq!((report.from_format, report.to_format, &report.to), (Format::Log, Format::Mcap, &None));
    let found = checked(&bag.bytes);
    assert_eq!(found.result.records, bag.messages.len() as u64);
    assert_eq!(found.result.summary.releases()[0].release, "px4@1.17");
    let (report, output) = changed(&bag.bytes, Format::Log, None).expect("a conversion");
    assert!(report.is_complete() && report.count(Action::LeftOut) == 0, "{}", report.to_text());
    let (before, mut after) = (content(&bytes), content(&output));
    // A log may declare formats without data.
    after.insert('F', before[&'F'].clone());
    for (kind, entries) in &before {
        assert_eq!(Some(entries), after.get(kind), "{kind}");
    }
    assert_eq!(before.len(), after.len());
}

#[test]
fn bags_have_the_names_and_types_of_ros() {
    let flight = short_flight("px4@1.17");
    let status = flight.topics.iter().position(|topic| topic.name == "vehicle_status").expect("a topic");
    let mut log = flight.log();
    let id = u16::try_from(status).expect("an id");
    log.entries.retain(|entry| match entry {
        Entry::Subscription(known, ..) | Entry::Data(known, _) => *known == id,
        _ => true,
    });
    let instance = |entry: &Entry| match entry {
        Entry::Subscription(_, _, name) => Entry::Subscription(500, 3, name.clone()),
        Entry::Data(_, payload) => Entry::Data(500, payload.clone()),
        other => other.clone(),
    };
    let data = log.entries.iter().position(|entry| matches!(entry, Entry::Subscription(..))).expect("data");
    let second: Vec<Entry> = log.entries[data..].iter().map(instance).collect();
    log.entries.extend(second);
    let (report, bag) = bag_of(&log.to_bytes(), None);
    let names: Vec<_> = report.topics.iter().map(|topic| (&*topic.topic, topic.renamed.as_deref())).collect();
    // In 1.17, this message has version 1.
    let expected = ["/fmu/out/vehicle_status_v1", "/fmu/out/vehicle_status3_v1"];
    assert_eq!(names[0], ("vehicle_status", Some(expected[0])));
    assert_eq!(names[1], ("vehicle_status (instance 3)", Some(expected[1])));
    assert_eq!(bag.messages(expected[0]).len(), bag.messages(expected[1]).len());
    let text = String::from_utf8_lossy(&bag.bytes).into_owned();
    assert!(text.contains("uint8 NAVIGATION_STATE_MANUAL"), "the schema has constants");
}

#[test]
fn times_are_in_utc_once_the_log_contains_it() {
    let [before, after] = [3_000_000_u64, 4_500_000];
    let position = |time: u64, utc: u64| [time.to_le_bytes(), utc.to_le_bytes()].concat();
    let [format, data] = topic(
        0,
        "vehicle_gps_position",
        "uint64_t time_utc_usec;",
        &[&position(before, 0), &position(after, UTC), &position(after + 1, 7)],
    );
    let text = (b'L', [b"3", &before.to_le_bytes()[..], b"No fix"].concat());
    let parameter = (b'P', keyed("int32_t A", &[1, 0, 0, 0]));
    let bytes = log(&[format, vec![parameter], data[..1].to_vec(), vec![text], data[1..].to_vec()].concat());
    let (report, bag) = bag_of(&bytes, None);
    assert_eq!(report.notes, [""; 0]);
    let times: Vec<u64> =
        bag.messages("/fmu/out/vehicle_gps_position").into_iter().map(|(time, _)| time / 1000).collect();
    assert_eq!(times, [UTC - 1_500_000, UTC, UTC + 1]);
    let texts = bag.messages("/rosout");
    let stamp = json!({"sec": 1_699_999_998, "nanosec": 500_000_000});
    assert_eq!((texts[0].0, &texts[0].1["stamp"]), ((UTC - 1_500_000) * 1000, &stamp));
    assert_eq!((&texts[0].1["level"], &texts[0].1["msg"]), (&json!(40), &json!("No fix")));
    // Without a plausible time, the times stay those of the vehicle.
    let [format, data] = topic(0, "vehicle_gps_position", "uint64_t time_utc_usec;", &[&position(before, 0)]);
    let (report, bag) = bag_of(&log(&[format, data].concat()), None);
    assert_eq!(bag.messages[0].0, before * 1000);
    assert!(report.notes[0].contains("UTC"), "{:?}", report.notes);
}

#[test]
fn events_are_decoded_with_the_metadata_of_the_log() {
    let flight = short_flight("px4@1.16");
    let mut log = flight.log();
    let (report, bag) = bag_of(&log.to_bytes(), None);
    assert!(report.is_complete(), "{}", report.to_text());
    let events = |bag: &Bag| -> Vec<Value> {
        let texts = bag.messages("/rosout").into_iter();
        texts.map(|(_, text)| text.clone()).filter(|text| text["name"] == "px4.event").collect()
    };
    let decoded = events(&bag);
    assert!(!decoded.is_empty() && decoded.iter().any(|event| event["function"] != ""), "{decoded:?}");
    assert_eq!(bag.messages("/fmu/out/event").len(), decoded.len());
    // Metadata of another firmware could explain an event wrongly.
    log.entries.retain(|entry| !matches!(entry, Entry::Metadata(_)));
    let (_, bag) = bag_of(&log.to_bytes(), None);
    let raw = events(&bag);
    assert_eq!(raw.len(), decoded.len());
    let is_raw = |event: &Value| {
        event["msg"].as_str().is_some_and(|text| text.starts_with("event ")) && event["function"] == ""
    };
    assert!(raw.iter().all(is_raw), "{raw:?}");
}

#[test]
fn topics_without_a_definition_keep_their_fields() {
    let mut data =
        [&9_u64.to_le_bytes()[..], &[7, 0, 0, 0, 0, 0, 0, 0], &[1, 0, 0, 0], &[5, 0, 0, 0]].concat();
    let fields = "bool is_open;uint8_t[7] _padding0;gust[1] gusts;";
    let [mut format, messages] = topic(4, "wing_flap", fields, &[&data]);
    format.insert(0, (b'F', b"gust:float speed;int16_t turn;uint8_t[2] _padding0;".to_vec()));
    let bytes = log(&[format, messages].concat());
    let (report, bag) = bag_of(&bytes, None);
    let topic = &report.topics[0];
    assert_eq!((topic.action, topic.renamed.as_deref()), (Action::Copied, Some("/fmu/out/wing_flap")));
    let message = bag.messages("/fmu/out/wing_flap")[0].1;
    assert_eq!(message["gusts"][0]["turn"], 5);
    assert_eq!((&message["timestamp"], &message["is_open"]), (&json!(9), &json!(true)));
    let text = String::from_utf8_lossy(&bag.bytes).into_owned();
    assert!(text.contains("px4_msgs/msg/WingFlap") && text.contains("MSG: px4_msgs/Gust\n"));
    let (report, output) = changed(&bag.bytes, Format::Log, None).expect("a conversion");
    assert_eq!(report.topics[0].renamed.as_deref(), Some("wing_flap"), "{}", report.to_text());
    // Any byte except 0 is true.
    data[8] = 1;
    assert_eq!(content(&output)[&'D'], [[b"wing_flap\0", &data[..]].concat()]);
}

#[test]
fn a_bag_can_get_another_release_at_the_same_time() {
    let log = short_flight("px4@1.13").log();
    let (report, bag) = bag_of(&log.to_bytes(), Some(release("px4@1.16")));
    assert_eq!(report.to.as_deref(), Some("px4@1.16"));
    assert!(report.count(Action::Converted) > 100);
    assert!(report.topics.iter().any(|topic| !topic.losses.is_empty()), "losses are reported");
    let found = checked(&bag.bytes);
    let releases = found.result.summary.releases();
    let px4 = releases.iter().find(|found| found.release.starts_with("px4")).expect("a release of PX4");
    assert_eq!((&*px4.release, px4.matching), ("px4@1.16", px4.topics));
}

#[test]
fn truncated_captures_are_converted_as_far_as_possible() {
    let log = short_flight("px4@1.16").log().to_bytes();
    let whole = bag_of(&log, None).1;
    for size in [0, 8, 200, log.len() / 2, log.len() - 1] {
        let (report, bag) = bag_of(head_of_log(&log, size), None);
        assert!(bag.messages.len() <= whole.messages.len());
        let counted: u64 = report.topics.iter().map(|topic| topic.messages - topic.unreadable).sum();
        assert_eq!(counted, bag.messages.len() as u64);
    }
    for size in [whole.bytes.len() / 2, whole.bytes.len() - 9] {
        let (report, output) = changed(&whole.bytes[..size], Format::Log, None).expect("a conversion");
        assert!(!report.is_complete());
        let data = content(&output).remove(&'D').unwrap_or_default();
        assert!(data.len() <= whole.messages.len());
    }
}

#[test]
fn other_topics_and_formats_are_refused() {
    let error = changed(b"{\"type\": \"px4/Event\"}\n", Format::Mcap, None).expect_err("JSON");
    assert!(matches!(error, Error::Input(reason) if reason == "JSON can't be converted to MCAP"));
    let bag = [
        mcap::schema(1, "std_msgs/msg/String", "ros2msg", b"string data\n"),
        mcap::channel(1, 1, "/chatter", "cdr", &[]),
        mcap::message(1, &[0, 1, 0, 0, 1, 0, 0, 0, 0]),
    ];
    let bag = mcap::file(&bag.concat());
    let (report, output) = changed(&bag, Format::Log, None).expect("a conversion");
    let topic = &report.topics[0];
    assert_eq!(
        (topic.action, topic.reason.as_deref()),
        (Action::LeftOut, Some("its type isn't in px4_msgs"))
    );
    assert_eq!(content(&output).get(&'D'), None);
}

/// A bag with these records, and a topic of PX4 on channel 1.
fn bag_with(records: &[Vec<u8>]) -> Vec<u8> {
    let request = "uint64 timestamp\nfloat32 x\n";
    let own = [
        mcap::schema(1, "px4_msgs/msg/Foo", "ros2msg", request.as_bytes()),
        mcap::channel(1, 1, "/fmu/out/foo", "cdr", &[]),
    ];
    mcap::file(&[&own[..], records].concat().concat())
}

/// A message of `/fmu/out/foo` in CDR.
fn foo(timestamp: u64) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &timestamp.to_le_bytes(), &[0; 4]].concat()
}

/// A message of `rcl_interfaces/msg/Log` in CDR, and the records that declare its channel.
fn text(logger: &str, seconds: u32, message: &str) -> [Vec<u8>; 3] {
    let definition = "uint8 DEBUG=10\nuint8 INFO=20\nuint8 WARN=30\nuint8 ERROR=40\nuint8 FATAL=50\n\
                      builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\n\
                      string function\nuint32 line\n";
    let mut cdr = [&[0, 1, 0, 0][..], &seconds.to_le_bytes(), &[0; 4], &[30]].concat();
    for string in [logger, message, "", ""] {
        cdr.resize((cdr.len() - 4).next_multiple_of(4) + 4, 0);
        cdr.extend(u32::try_from(string.len() + 1).expect("a length").to_le_bytes());
        cdr.extend_from_slice(string.as_bytes());
        cdr.push(0);
    }
    cdr.resize((cdr.len() - 4).next_multiple_of(4) + 8, 0);
    let name = "rcl_interfaces/msg/Log";
    [
        mcap::schema(2, name, "ros2msg", definition.as_bytes()),
        mcap::channel(2, 2, "/rosout", "cdr", &[]),
        mcap::message(2, &cdr),
    ]
}

#[test]
fn texts_have_the_time_of_the_vehicle() {
    let mut records = text("px4", 1_000, "before").to_vec();
    // The message says that the vehicle started at 999 s.
    records.push(mcap::message_at(1, 1_001_000_000_000, &foo(2_000_000)));
    records.push(text("px4", 1_003, "after")[2].clone());
    records.push(text("planner", 1_003, "other")[2].clone());
    records.push(text("px4", 1_003, &"long".repeat(20_000))[2].clone());
    let information = BTreeMap::from([("char[4] sys_name".to_owned(), "long".repeat(20_000))]);
    records.push(mcap::record(0x0c, &[&metadata_body("ulog:information", &information)]));
    let (report, output) = changed(&bag_with(&records), Format::Log, None).expect("a conversion");
    let line = |time: u64, text: &str| [b"4", &time.to_le_bytes()[..], text.as_bytes()].concat();
    let mut expected = [line(1_000_000, "before"), line(4_000_000, "after")];
    expected.sort();
    assert_eq!(content(&output)[&'L'], expected);
    let texts = report.topics.iter().find(|topic| topic.topic == "/rosout").expect("a topic");
    assert_eq!(texts.reason.as_deref(), Some("texts of other nodes are left out"));
    assert_eq!((texts.messages, texts.unreadable), (4, 1));
    assert!(report.problems[0].starts_with("information of 80021 bytes"), "{:?}", report.problems);
    assert_eq!(content(&output).get(&'I'), None);
}

#[test]
fn topics_keep_their_names_and_instances() {
    let topics = [("flap", 1), ("flap1", 0), ("flap_2", 1), ("wingTip", 3), ("tip_v2", 0)];
    let mut messages = Vec::new();
    for (name, _) in topics {
        messages.push((b'F', format!("{name}:uint64_t timestamp;").into_bytes()));
    }
    for (id, (name, multi_id)) in (0_u16..).zip(topics) {
        messages.push((b'A', [&[multi_id], &id.to_le_bytes()[..], name.as_bytes()].concat()));
        messages.push((b'D', [&id.to_le_bytes()[..], &7_u64.to_le_bytes()].concat()));
    }
    let before = log(&messages);
    let (report, bag) = bag_of(&before, None);
    let mut names: Vec<_> = report.topics.iter().filter_map(|topic| topic.renamed.clone()).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), topics.len(), "each topic has its own name");
    let (_, output) = changed(&bag.bytes, Format::Log, None).expect("a conversion");
    assert_eq!(content(&output)[&'D'], content(&before)[&'D']);
}

#[test]
fn contradictory_and_unusable_channels_are_reported() {
    let records = [
        mcap::message(1, &foo(5)),
        mcap::schema(3, "px4_msgs/msg/Bar", "ros2msg", b"uint64 timestamp\nuint32 y\n"),
        mcap::channel(1, 3, "/fmu/out/bar", "cdr", &[]),
        mcap::channel(4, 1, "/fmu/out/a:b", "cdr", &[]),
        mcap::channel(5, 9, "/fmu/out/lost", "cdr", &[]),
        mcap::channel(6, 0, "/fmu/out/bare", "cdr", &[]),
        mcap::channel(7, 1, "/fmu/out/text", "json", &[]),
    ];
    let (report, output) = changed(&bag_with(&records), Format::Log, None).expect("a conversion");
    assert_eq!(content(&output)[&'D'].len(), 1);
    assert_eq!(report.problems.len(), 2, "{:?}", report.problems);
    assert!(report.problems[0].contains("channel 1 is declared again"), "{:?}", report.problems);
    let reason = |name: &str| {
        let topic = report.topics.iter().find(|topic| topic.topic == name).expect("a topic");
        topic.reason.as_deref().unwrap_or_default()
    };
    for (topic, expected) in [
        ("/fmu/out/a:b", "a log can't have a topic `a:b`"),
        ("/fmu/out/lost", "its schema 9 hasn't been declared yet"),
        ("/fmu/out/bare", "it has no schema"),
        ("/fmu/out/text", "expected CDR messages, found `json`"),
    ] {
        assert_eq!(reason(topic), expected);
    }
}
