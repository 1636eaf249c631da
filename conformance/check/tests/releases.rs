//! Tests of the choice of the release for a capture.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_check::{Checked, PartResult, ReleaseMatch, Share, check_bytes, check_path};
use uavspec_model::Level;
use uavspec_report::{CheckedCapture, OutcomeKind, Settings, Subject};
use uavspec_rules::definitions::{Library, versioned};
use uavspec_rules::sample::{Bag, Flight};
use uavspec_test_captures::mcap as file;
use uavspec_test_support::{extent, shared};

static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

const RELEASES: [&str; 7] = ["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"];

/// The first two rounds of a flight.
fn short_flight(library: &Library) -> Flight<'_> {
    let mut flight = Flight::new(library.base());
    flight.messages.truncate(2 * flight.topics.len());
    flight
}

/// A whole flight; in quick mode, only its first two rounds.
fn flight(library: &Library) -> Flight<'_> {
    if extent(true, false) { Flight::new(library.base()) } else { short_flight(library) }
}

/// The tested releases, each with a flight.
static FLIGHTS: LazyLock<Vec<(&str, Flight<'static>)>> = LazyLock::new(|| {
    let flight = |name: &'static str| {
        let library: &'static Library = Box::leak(Box::new(release(name)));
        (name, short_flight(library))
    };
    RELEASES.into_iter().step_by(extent(1, 4)).map(flight).collect()
});

fn release(name: &str) -> Library {
    Library::load(Path::new(&format!("px4@{name}")), None).expect("a release")
}

/// Writes a file, and checks it.
fn checked(name: &str, bytes: &[u8]) -> Checked {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a file");
    check_path(&path, None, &LIBRARY, &|input| input).expect("the path can be opened")
}

/// The chosen releases: their numbers of matching topics and of all topics, and the topics that were checked against
/// other releases.
fn chosen(checked: &Checked) -> Vec<(&str, u64, u64, Vec<&str>)> {
    let facts = |found: &'_ ReleaseMatch| -> (u64, u64) { (found.matching, found.topics) };
    let releases = checked.result.summary.releases().iter();
    let describe = releases.map(|found| {
        let (matching, topics) = facts(found);
        (
            found.release.as_str(),
            matching,
            topics,
            found.others.iter().map(|other| other.topic.as_str()).collect(),
        )
    });
    describe.collect()
}

/// The violated MUST rules, with their topics and messages.
fn failures(checked: &Checked) -> Vec<(&str, &str, Vec<String>)> {
    let groups = checked.result.findings.groups().filter(|group| group.rule.level == Level::Must);
    groups.map(|group| (group.rule.id, &*group.subject, group.messages())).collect()
}

fn subject(checked: Checked) -> Subject {
    let capture = CheckedCapture {
        path: "capture".to_owned(),
        result: checked.result,
        notes: Vec::new(),
        requests: Vec::new(),
        cut_short: Vec::new(),
        elapsed: 0,
    };
    Subject::from_capture(capture, &checked.definitions, &Settings::default())
}

/// A bag without the definitions in its channels.
fn anonymous(flight: &Flight<'_>) -> Bag {
    let mut bag = flight.bag();
    bag.channels.iter_mut().for_each(|channel| channel.text.clear());
    bag
}

fn without_hashes(mut bag: Bag) -> Bag {
    bag.channels.iter_mut().for_each(|channel| channel.hash.clear());
    bag
}

/// A bag in which only the versions in the topic names distinguish definitions of the same size.
fn unnamed(flight: &Flight<'_>) -> Bag {
    let mut bag = without_hashes(anonymous(flight));
    for (channel, topic) in bag.channels.iter_mut().zip(&flight.topics) {
        let version = flight.definitions.schema.message(topic.message).version;
        channel.topic = versioned(&channel.topic, version);
    }
    bag
}

/// A kind of capture, the file name, and a function that writes a flight as such a capture.
type Capture = (&'static str, &'static str, fn(&Flight<'_>) -> Vec<u8>);

const CAPTURES: [Capture; 5] = [
    ("log", "log.ulg", |flight| flight.log().to_bytes()),
    ("bag", "bag.mcap", |flight| flight.bag().to_bytes()),
    ("bag without hashes", "bag.mcap", |flight| without_hashes(flight.bag()).to_bytes()),
    ("bag without schemas", "bag.mcap", |flight| anonymous(flight).to_bytes()),
    ("bag without schemas and hashes", "bag.mcap", |flight| unnamed(flight).to_bytes()),
];

#[test]
fn captures_of_each_release_are_checked_against_it() {
    // In quick mode, the first release is tested with the first kind of capture, and another release with the last
    // kind.
    for (number, (name, flight)) in FLIGHTS.iter().enumerate() {
        let topics = flight.topics.len() as u64;
        assert!(topics > 100, "{topics}");
        let label = format!("px4@{name}");
        for (kind, file, write) in CAPTURES.into_iter().skip(extent(0, 4 * number)).step_by(extent(1, 5)) {
            let bytes = write(flight);
            let found = checked(file, &bytes);
            assert_eq!(chosen(&found), [(&*label, topics, topics, vec![])], "{kind}");
            let streamed = check_bytes(&bytes, &LIBRARY).expect("bytes can be read");
            assert_eq!(chosen(&streamed), chosen(&found), "{kind}");
            assert_eq!(failures(&found), [], "{name} {kind}");
        }
    }
}

#[test]
fn json_messages_of_each_release_are_checked_against_it() {
    for (name, flight) in FLIGHTS.iter() {
        let label = format!("px4@{name}");
        for (kind, lines) in [("typed", flight.lines()), ("published", flight.rosbridge())] {
            let found = checked("flight.jsonl", &lines.to_bytes());
            let releases = chosen(&found);
            assert_eq!(releases.len(), 1, "{name} {kind}");
            let (chosen, matching, topics, ref others) = releases[0];
            assert_eq!((chosen, matching, others), (&*label, topics, &vec![]), "{kind}");
            assert!(topics > 100, "{name} {kind}: {topics}");
            assert_eq!(failures(&found), [], "{name} {kind}");
        }
    }
}

/// If few topics indicate the release, array lengths and the keys of nested messages determine the definition.
#[test]
fn json_messages_are_checked_against_a_definition_of_their_form() {
    let cases = [
        ("1.13", "EscStatus"),
        ("1.14", "ActuatorServos"),
        ("1.14", "RcChannels"),
        ("1.15", "PositionSetpointTriplet"),
    ];
    for (name, message) in cases.into_iter().step_by(extent(1, 3)) {
        let library = release(name);
        let mut flight = Flight::new(library.base());
        let topics = ["Cpuload", message].map(|name| flight.topic(name).expect("a topic"));
        flight.messages.retain(|sent| topics.contains(&sent.topic));
        for lines in [flight.lines(), flight.rosbridge()] {
            let found = checked("flight.jsonl", &lines.to_bytes());
            assert_eq!(failures(&found), [], "{name} {message}");
            assert_eq!(found.result.checked, flight.messages.len() as u64, "{name} {message}");
        }
    }
}

/// A capture with JSON messages, in two forms: as rosbridge messages, and in a bag without schemas.
fn json_captures(topic: &str, messages: &[&Value]) -> [(&'static str, Vec<u8>); 2] {
    let line = |message: &&Value| json!({"op": "publish", "topic": topic, "msg": message}).to_string() + "\n";
    let lines: String = messages.iter().map(line).collect();
    let payloads = messages.iter().map(|message| file::message(1, message.to_string().as_bytes()));
    let records: Vec<_> = [file::channel(1, 0, topic, "json", &[])].into_iter().chain(payloads).collect();
    [("topic.jsonl", lines.into_bytes()), ("topic.mcap", file::file(&records.concat()))]
}

/// A message of the type `BatteryStatus` of a PX4 release.
fn battery_status(version: &str) -> Value {
    let library = release(version);
    let flight = Flight::new(library.base());
    let topic = flight.topic("BatteryStatus").expect("a topic");
    let sent = flight.messages.iter().find(|sent| sent.topic == topic).expect("a message");
    sent.value.clone()
}

/// Other programs use the names of PX4 topics for other types.
#[test]
fn names_of_json_topics_outside_of_px4_need_the_keys_of_the_type() {
    let of_px4 = &battery_status("1.17");
    let mut longer = of_px4.clone();
    longer["tow"] = json!(1);
    let other = json!({"timestamp": 1, "voltage": 12.1, "percentage": 0.5});
    let short = json!({"timestamp": 1});
    let ros = json!({"header": {"frame_id": "base"}, "voltage": 12.1, "current": -1.0, "present": true});
    for (topic, message, is_checked, has_failures) in [
        ("/fmu/out/battery_status", of_px4, true, false),
        ("/fmu/out/battery_status", &other, true, true),
        ("/left/fmu/out/battery_status", &ros, true, true),
        ("/battery_status", of_px4, true, false),
        ("/robot/battery_status", &longer, true, true),
        ("/robot/battery_status/0", &other, false, false),
        ("/battery_status", &short, false, false),
        ("battery_status", &ros, false, false),
        ("/robot/battery_status", &json!([1]), false, false),
    ] {
        for (name, bytes) in json_captures(topic, &[message]) {
            let found = checked(name, &bytes);
            let facts = (found.result.checked > 0, !failures(&found).is_empty());
            assert_eq!(facts, (is_checked, has_failures), "{name} {topic} {message}");
            assert_eq!((found.result.records, found.result.corruption.len()), (1, 0), "{name} {topic}");
        }
    }
}

/// The first non-empty message determines the definition and the release. Earlier messages aren't checked.
#[test]
fn json_messages_without_keys_decide_nothing() {
    let (of_px4, other) = (&battery_status("1.14"), &json!({"voltage": 12.1}));
    let (empty, null) = (&json!({}), &json!(null));
    let [partial, incomplete] =
        [(PartResult::Keyless, OutcomeKind::Partial), (PartResult::Undefined, OutcomeKind::Incomplete)];
    for (messages, checked_count, expected) in [
        (&[empty, null, of_px4, of_px4][..], 2, partial),
        (&[null, empty, of_px4], 1, partial),
        (&[empty, other, of_px4, empty], 0, incomplete),
        (&[empty, null, empty], 0, incomplete),
    ] {
        for (name, bytes) in json_captures("/robot/battery_status", messages) {
            let found = checked(name, &bytes);
            assert_eq!(failures(&found), [], "{name} {messages:?}");
            let (result, count) = (&found.result, messages.len() as u64);
            let facts = (result.records, result.checked, result.corruption.len());
            assert_eq!(facts, (count, checked_count, 0), "{name} {messages:?}");
            let covered = (result.coverage.records, result.coverage.units);
            assert_eq!(covered, (Share::of(checked_count, count), Share::of(0, 1)), "{name} {messages:?}");
            let part = result.coverage.parts[0].result;
            let outcome = subject(found).outcome;
            assert_eq!((part, outcome.kind), expected, "{name} {messages:?}: {}", outcome.text);
        }
    }
}

/// `std_msgs/msg/Empty` has no fields.
#[test]
fn json_messages_of_a_type_without_fields_conform() {
    let ty = "std_msgs/msg/Empty";
    let typed = json!({"type": ty, "message": {}}).to_string();
    let advertised = json!({"op": "advertise", "topic": "/trigger", "type": ty});
    let published = json!({"op": "publish", "topic": "/trigger", "msg": {}});
    let records = [
        file::schema(1, ty, "ros2msg", &[]),
        file::channel(1, 1, "/trigger", "json", &[]),
        file::message(1, b"{}"),
    ];
    for (name, bytes) in [
        ("typed.jsonl", typed.into_bytes()),
        ("trigger.jsonl", format!("{advertised}\n{published}\n").into_bytes()),
        ("trigger.mcap", file::file(&records.concat())),
    ] {
        let found = checked(name, &bytes);
        assert_eq!(found.result.checked, 1, "{name}");
        let outcome = subject(found).outcome;
        assert_eq!(outcome.kind, OutcomeKind::Conforms, "{name}: {}", outcome.text);
    }
}

#[test]
fn user_definitions_apply_to_json_topics_of_any_name() {
    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("Kite.msg"), "uint64 timestamp\nfloat32 pull\n").expect("a file");
    let library = Library::load(folder.path(), None).expect("definitions");
    for (name, bytes) in json_captures("/robot/kite", &[&json!({"angle": 1})]) {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("a file");
        let found = check_path(&path, None, &library, &|input| input).expect("a capture");
        assert_eq!(failures(&found).len(), 2, "{name}");
    }
}

/// A bag with JSON messages. The name of each schema is the type if `has_types` is true; otherwise, it is empty.
fn json_bag(flight: &Flight<'_>, has_types: bool) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WriteOptions::new().compression(None).create(&mut bytes).expect("a writer");
    let bag = flight.bag();
    let channels = bag.channels.iter().map(|channel| {
        let name = if has_types { channel.schema.as_str() } else { "" };
        let schema = writer.add_schema(name, "jsonschema", b"{}").expect("a schema");
        writer.add_channel(schema, &channel.topic, "json", &BTreeMap::new()).expect("a channel")
    });
    let channels: Vec<u16> = channels.collect();
    for (sent, (channel, time, _)) in flight.messages.iter().zip(&bag.messages) {
        let channel_id = channels[usize::from(*channel)];
        let header = MessageHeader { channel_id, sequence: 0, log_time: *time, publish_time: *time };
        writer.write_to_known_channel(&header, sent.value.to_string().as_bytes()).expect("a message");
    }
    writer.finish().expect("a summary");
    drop(writer);
    bytes.into_inner()
}

#[test]
fn bags_with_json_messages_of_each_release_are_checked_against_it() {
    for (name, flight) in FLIGHTS.iter() {
        let label = format!("px4@{name}");
        for has_types in [false, true] {
            let found = checked("bag.mcap", &json_bag(flight, has_types));
            let releases: Vec<&str> = chosen(&found).iter().map(|(release, ..)| *release).collect();
            assert_eq!(releases, [&*label], "{has_types}");
            assert_eq!(failures(&found), [], "{name} {has_types}");
        }
    }
}

#[test]
fn topics_of_other_releases_are_checked_against_those() {
    let (main, other) = (release("1.14"), release("1.17"));
    let [mut bag, newer] = [&main, &other].map(|library| flight(library).bag());
    let topic = "/fmu/out/vehicle_status";
    let position =
        |bag: &uavspec_rules::sample::Bag| bag.channels.iter().position(|channel| channel.topic == topic);
    let (at, from) = (position(&bag).expect("a channel"), position(&newer).expect("a channel"));
    bag.channels[at] = newer.channels[from].clone();
    let payload = |bag: &uavspec_rules::sample::Bag, index: usize| {
        let found = bag.messages.iter().find(|(channel, ..)| usize::from(*channel) == index);
        found.map(|(_, _, payload)| payload.clone()).expect("a message")
    };
    let sent = payload(&newer, from);
    for (channel, _, payload) in &mut bag.messages {
        if usize::from(*channel) == at {
            payload.clone_from(&sent);
        }
    }
    let found = checked("bag.mcap", &bag.to_bytes());
    let releases = chosen(&found);
    assert_eq!((releases[0].0, &releases[0].3), ("px4@1.14", &vec![topic]));
    assert_eq!(releases[0].1 + 1, releases[0].2);
    let text = uavspec_report::subject_text(&subject(found));
    assert!(text.contains("vehicle_status: px4@1.16"), "{text}");
}

#[test]
fn forced_releases_apply_to_all_captures() {
    let bytes = flight(&release("1.18")).bag().to_bytes();
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("bag.mcap");
    fs::write(&path, bytes).expect("a file");
    let found = check_path(&path, None, &release("1.13"), &|input| input).expect("a capture");
    assert_eq!(chosen(&found)[0].0, "px4@1.13");
    assert!(chosen(&found)[0].3.is_empty());
}

/// If firmware matches no release, its messages are checked as far as possible.
#[test]
fn unknown_firmware_is_incomplete() {
    let library = release("1.13");
    let mut log = Flight::new(library.base()).log();
    for entry in &mut log.entries {
        if let uavspec_rules::sample::Entry::Format(_, fields) = entry {
            fields.push_str("uint64_t serial_of_the_club;");
        }
        if let uavspec_rules::sample::Entry::Data(_, payload) = entry {
            payload.extend([0; 8]);
        }
    }
    let found = checked("log.ulg", &log.to_bytes());
    let outcome = subject(found).outcome;
    assert_ne!(outcome.kind, OutcomeKind::Conforms);
    assert_ne!(outcome.kind, OutcomeKind::Partial, "{}", outcome.text);
}

#[test]
fn bags_of_ros_systems_are_checked() {
    let Some(bags) = shared("corpus/bags") else { return };
    let mut judged = 0;
    for entry in walkdir::WalkDir::new(&bags).sort_by_file_name() {
        let path: PathBuf = entry.expect("a file").into_path();
        if !path.join("metadata.yaml").is_file() {
            continue;
        }
        let found = check_path(&path, None, &LIBRARY, &|input| input).expect("a bag");
        assert_eq!(found.result.findings.groups().count(), 0, "{}", path.display());
        judged += usize::from(found.result.checked > 0);
    }
    assert!(judged >= 10, "{judged}");
}
