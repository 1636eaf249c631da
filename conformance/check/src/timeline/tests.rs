//! Tests of timelines.

use std::fs;

use serde_json::{Value as Json, json};
use uavspec_rules::sample::{Encoding, Entry, Flight, PERIOD, START};
use uavspec_schema::translation::Translations;
use uavspec_test_support::extent;

use super::*;
use crate::limits::MAX_CHANGES;

const REQUIRED: &str = "mode_req_attitude";
const FLAG: &str = "attitude_invalid";

fn texts() -> Texts {
    Texts::of(Translations::default())
}

fn timeline(bytes: &[u8], definitions: &Definitions) -> Timeline {
    Timeline::of_bytes(bytes, definitions, &texts()).expect("a readable capture")
}

/// A flight in which a flag is set in the rounds for which `is_set` returns true.
fn flight_with_flag(definitions: &Definitions, is_set: impl Fn(u64) -> bool) -> Flight<'_> {
    let mut flight = Flight::new(definitions);
    let topic = flight.topic("FailsafeFlags").expect("a topic");
    for sent in flight.messages.iter_mut().filter(|sent| sent.topic == topic) {
        let round = (sent.value["timestamp"].as_u64().expect("a time") - START) / PERIOD;
        for (name, value) in sent.value.as_object_mut().expect("an object") {
            if value.is_boolean() {
                *value = (name == FLAG && is_set(round)).into();
            }
        }
    }
    flight
}

fn lane<'s>(timeline: &'s Timeline, topic: &str, name: &str) -> &'s Lane {
    let mut found = timeline.lanes.iter().filter(|lane| lane.topic == topic && lane.name == name);
    found.next().unwrap_or_else(|| panic!("no lane {topic}.{name}"))
}

/// The changes of a lane: the times in µs, and the names of the new values.
fn changes(lane: &Lane) -> Vec<(i64, String)> {
    let names = |value: &Value| value.parts.iter().map(|part| &*part.name).collect::<Vec<_>>().join("; ");
    lane.changes.iter().map(|change| (change.time_us, names(&lane.values[change.value]))).collect()
}

fn texts_of(found: &[(i64, String)]) -> Vec<(i64, &str)> {
    found.iter().map(|(time, text)| (*time, text.as_str())).collect()
}

/// JSON Lines of messages with a type.
fn lines(messages: &[(&str, Json)]) -> Vec<u8> {
    let line = |(ty, message): &(&str, Json)| format!("{}\n", json!({ "type": ty, "message": message }));
    messages.iter().map(line).collect::<String>().into_bytes()
}

/// Definitions with a message `VehicleStatus` in addition to `FailsafeFlags`.
fn with_status(status: &str) -> Definitions {
    let folder = tempfile::tempdir().expect("a folder");
    let flags = "uint64 timestamp\nuint32 mode_req_attitude\n\n# Limits\nbool attitude_invalid  # Attitude lost. It is.\n";
    fs::write(folder.path().join("FailsafeFlags.msg"), flags).expect("a file");
    fs::write(folder.path().join("VehicleStatus.msg"), status).expect("a file");
    Definitions::load(folder.path()).expect("definitions")
}

#[test]
fn tells_when_a_flag_is_set_and_cleared() {
    let definitions = Definitions::built_in();
    let flight = flight_with_flag(&definitions, |round| (10..20).contains(&round));
    let timeline = timeline(&flight.log().to_bytes(), &definitions);
    let flag = lane(&timeline, "failsafe_flags", FLAG);
    let first = flag.changes[0].time_us;
    let period = i64::try_from(PERIOD).expect("a small number");
    let expected = [(first, "cleared"), (first + 10 * period, "set"), (first + 20 * period, "cleared")];
    assert_eq!(texts_of(&changes(flag)), expected);
    assert_eq!((flag.set_us(), flag.num_changes()), (10 * PERIOD, 2));
    let label = flag.label.as_ref().expect("a label");
    assert_eq!(label.text, "No valid attitude");
    assert_ne!(label.in_language("uk"), label.text);
    assert_eq!(label.in_language("xx"), label.text);
    assert_eq!(flag.group.as_ref().map(|group| &*group.text), Some("Mode requirements"));
    let quiet = lane(&timeline, "failsafe_flags", "gcs_connection_lost");
    assert_eq!((quiet.num_changes(), quiet.listed().count()), (0, 0));
}

#[test]
fn all_encodings_tell_the_same_timeline() {
    let definitions = Definitions::built_in();
    let flight = flight_with_flag(&definitions, |round| round % 7 == 3);
    let lanes_in = |encoding: Encoding| {
        let mut bytes = encoding.write(&flight).expect("an encoded flight");
        if encoding == Encoding::Ulog {
            // The other encodings contain no event metadata.
            let mut log = flight.log();
            log.entries.retain(|entry| !matches!(entry, Entry::Metadata(_)));
            bytes = log.to_bytes();
        }
        let timeline = timeline(&bytes, &definitions);
        assert_eq!(timeline.unreadable_messages, 0, "{}", encoding.name());
        let from_first = |lane: &Lane| {
            let found = changes(lane);
            let times: Vec<(i64, String)> =
                found.iter().map(|(time, text)| (time - found[0].0, text.clone())).collect();
            // JSON Lines and bags don't number the instances of a topic.
            (lane.topic.clone(), lane.name.clone(), times, lane.set_us())
        };
        timeline.lanes.iter().map(from_first).collect::<Vec<_>>()
    };
    let log = lanes_in(Encoding::Ulog);
    assert!(log.len() > 20, "{}", log.len());
    assert!(log.iter().any(|(topic, ..)| topic == "register_ext_component_request"));
    for encoding in [Encoding::Mcap, Encoding::Lines, Encoding::Rosbridge] {
        let other = lanes_in(encoding);
        assert_eq!(other.len(), log.len(), "{}", encoding.name());
        for (other, lane) in other.iter().zip(&log) {
            assert_eq!(other, lane, "{}", encoding.name());
        }
    }
}

#[test]
fn tells_the_replies_of_each_component_with_their_reasons() {
    let definitions = Definitions::built_in();
    let timeline = timeline(&Flight::new(&definitions).lines().to_bytes(), &definitions);
    let replies: Vec<&Lane> =
        timeline.lanes.iter().filter(|lane| lane.topic == "arming_check_reply").collect();
    let subjects: Vec<&str> = replies.iter().filter_map(|lane| lane.subject.as_deref()).collect();
    assert!(
        matches!(subjects[..], [a, b] if a.starts_with("registration 3, ") && b.starts_with("registration 5, "))
    );
    let refused = &replies[0].values[replies[0].changes[0].value];
    assert_eq!((refused.parts[0].name.as_str(), refused.severity), ("false", Severity::Warning));
    let events = refused.parts.iter().filter(|part| part.name == "px4::check_modes_global_pos");
    assert_eq!(events.count(), 2, "only the used entries: {refused:?}");
    let requests = lane(&timeline, "arming_check_request", "valid_registrations_mask");
    assert_eq!(changes(requests)[0].1, "registration 3; registration 5");
    assert_eq!(changes(requests)[1].1, "registration 3", "a component was removed");
}

#[test]
fn replies_belong_to_the_component_that_has_the_id_at_that_time() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [
        ("ArmingCheckRequest", "uint64 timestamp\nuint32 valid_registrations_mask\n"),
        ("ArmingCheckReply", "uint64 timestamp\nuint8 registration_id\nbool can_arm_and_run\n"),
        (
            "RegisterExtComponentReply",
            "uint64 timestamp\nchar[25] name\nbool success\nint8 arming_check_id\n",
        ),
    ] {
        fs::write(folder.path().join(format!("{name}.msg")), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let request = |time: u64| {
        ("px4/ArmingCheckRequest", json!({ "timestamp": time, "valid_registrations_mask": 1 << 3 }))
    };
    let reply = |time: u64, can_run: bool| {
        let reply = json!({ "timestamp": time, "registration_id": 3, "can_arm_and_run": can_run });
        ("px4/ArmingCheckReply", reply)
    };
    let registered = |time: u64, name: &str, success: bool| {
        let reply = json!({ "timestamp": time, "name": name, "success": success, "arming_check_id": 3 });
        ("px4/RegisterExtComponentReply", reply)
    };
    let messages = [
        reply(1_000, true),
        registered(2_000, "Kite", true),
        request(3_000),
        registered(4_000, "Wren", false),
        reply(5_000, true),
        registered(6_000, "Owl", true),
        request(7_000),
        reply(8_000, false),
    ];
    let timeline = timeline(&lines(&messages), &definitions);
    let replies = timeline.lanes.iter().filter(|lane| lane.topic == "arming_check_reply");
    let found: Vec<_> =
        replies.map(|lane| (lane.subject.as_deref(), changes(lane), lane.values[0].duration_us)).collect();
    // The replies of the first component end when another component gets the id.
    let expected = [
        (Some("registration 3, Kite"), vec![(0, "true".to_owned())], 5_000),
        (Some("registration 3, Owl"), vec![(7_000, "false".to_owned())], 0),
    ];
    assert_eq!(found, expected);
    let requests = lane(&timeline, "arming_check_request", "valid_registrations_mask");
    assert_eq!(texts_of(&changes(requests)), [(2_000, "registration 3"), (6_000, "registration 3")]);
    let labels = requests.values.iter().map(|value| value.parts[0].label.as_ref().map(|label| &*label.text));
    assert_eq!(labels.collect::<Vec<_>>(), [Some("Kite"), Some("Owl")]);
}

#[test]
fn names_the_component_of_an_event() {
    let definitions = Definitions::built_in();
    let mut arguments = vec![0; 25];
    arguments[1] = 171;
    let event = json!({ "timestamp": 9, "id": (1 << 24) + 77, "event_sequence": 3, "arguments": arguments,
        "log_levels": 0x64 });
    let timeline = timeline(&lines(&[("px4/Event", event)]), &definitions);
    let event = &lane(&timeline, "event", "event").values[0];
    let expected = "event 16777293 (component 1, number 77), log levels 6 and 4, arguments 00 ab";
    assert_eq!((event.parts[0].name.as_str(), event.severity), (expected, Severity::Warning));
}

#[test]
fn limits_the_changes_of_a_lane_and_counts_the_others() {
    let definitions = Definitions::built_in();
    let count = MAX_CHANGES + 250;
    let mut flight = flight_with_flag(&definitions, |_| false);
    let topic = flight.topic("FailsafeFlags").expect("a topic");
    let typical = flight.messages.iter().find(|sent| sent.topic == topic).expect("a message").clone();
    flight.messages = (0..count as u64)
        .map(|number| {
            let mut sent = typical.clone();
            sent.value["timestamp"] = (START + number * 10_000).into();
            sent.value[FLAG] = (number % 2 == 1).into();
            sent
        })
        .collect();
    let timeline = timeline(&flight.lines().to_bytes(), &definitions);
    let flag = lane(&timeline, "failsafe_flags", FLAG);
    assert_eq!((flag.changes.len(), flag.more_changes), (MAX_CHANGES, 250));
    assert_eq!(flag.num_changes(), count as u64 - 1);
    assert_eq!(flag.set_us(), (count as u64 / 2 - 1) * 10_000, "the duration includes all changes");
}

#[test]
fn names_the_constants_and_the_unmet_requirements() {
    let status = "uint64 timestamp\nuint8 nav_state\nuint8 NAVIGATION_STATE_STAB = 15  # Stabilized. And more.\n\
                  uint8 NAVIGATION_STATE_LAND = 18\nuint8 NAVIGATION_STATE_MAX = 40\n";
    let definitions = with_status(status);
    let status = |time: u64, mode: u8| ("px4/VehicleStatus", json!({ "timestamp": time, "nav_state": mode }));
    let flags = |time: u64, is_set: bool| {
        ("px4/FailsafeFlags", json!({ "timestamp": time, REQUIRED: 1 << 18, FLAG: is_set }))
    };
    let messages = [
        status(1_000, 15),
        flags(2_000, true),
        status(3_000, 18),
        flags(4_000, false),
        status(5_000, 40),
        status(6_000, 200),
    ];
    let timeline = timeline(&lines(&messages), &definitions);
    let modes = lane(&timeline, "vehicle_status", "nav_state");
    assert_eq!(texts_of(&changes(modes)), [(0, "STAB"), (2_000, "LAND"), (4_000, "40"), (5_000, "200")]);
    let labels = |lane: &Lane| -> Vec<Option<String>> {
        let parts = lane.values.iter().flat_map(|value| &value.parts);
        parts.map(|part| part.label.as_ref().map(|label| label.text.clone())).collect()
    };
    assert_eq!(labels(modes), [Some("Stabilized".to_owned()), None, None, None]);
    let unmet = lane(&timeline, "failsafe_flags", "mode_req_*");
    assert_eq!(texts_of(&changes(unmet)), [(1_000, ""), (2_000, FLAG), (3_000, "")]);
    assert_eq!(labels(unmet), [Some("Attitude lost".to_owned())]);
}

#[test]
fn uses_the_built_in_texts_only_if_definitions_have_none() {
    let definitions = with_status("uint64 timestamp\n");
    let texts = Texts::of(Translations::default());
    let id = definitions.message_of_topic("failsafe_flags").expect("a message");
    let label = |item| texts.label(id, item, &definitions).expect("a label");
    assert_eq!(label(label::Item::Field(FLAG)).text, "Attitude lost");
    assert_eq!(label(label::Item::Group(FLAG)).text, "Limits");
    assert_eq!(label(label::Item::Field(REQUIRED)).text.split(':').next(), Some("Bit N"));
    assert!(label(label::Item::Field(FLAG)).translations.contains_key("uk"));
}

#[test]
fn finds_the_texts_of_constants_with_other_prefixes() {
    let folder = tempfile::tempdir().expect("a folder");
    let battery = "uint64 timestamp\nuint8 warning\nuint8 WARNING_LOW = 1\nuint8 WARNING_GONE = 2\n";
    fs::write(folder.path().join("BatteryStatus.msg"), battery).expect("a file");
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let status =
        |time: u64, warning: u8| ("px4/BatteryStatus", json!({ "timestamp": time, "warning": warning }));
    let timeline = timeline(&lines(&[status(1, 1), status(2, 2)]), &definitions);
    let values = &lane(&timeline, "battery_status", "warning").values;
    let labels = values.iter().map(|value| value.parts[0].label.as_ref().map(|label| &*label.text));
    assert_eq!(labels.collect::<Vec<_>>(), [Some("Low voltage"), None]);
}

#[test]
fn lists_the_topics_that_are_missing_or_have_no_definition() {
    let definitions = Definitions::built_in();
    let flight = flight_with_flag(&definitions, |_| false);
    let mut bytes = flight.lines().to_bytes();
    bytes.extend(lines(&[("px4/VehicleStatus", json!({ "timestamp": 7 }))]));
    let timeline = timeline(&bytes, &definitions);
    let status =
        |name: &str| timeline.topics.iter().find(|topic| topic.name == name).map(|topic| topic.status);
    assert_eq!(status("failsafe_flags"), Some(TopicStatus::Explained));
    assert_eq!(status("vehicle_status"), Some(TopicStatus::Undefined));
    let bytes = lines(&[("px4/Event", json!({ "timestamp": 7 }))]);
    let timeline = Timeline::of_bytes(&bytes, &definitions, &texts()).expect("a timeline");
    let status =
        |name: &str| timeline.topics.iter().find(|topic| topic.name == name).map(|topic| topic.status);
    assert_eq!((status("event"), timeline.unreadable_messages), (Some(TopicStatus::Explained), 1));
    assert_eq!(status("vehicle_status"), Some(TopicStatus::Absent));
}

#[test]
fn fields_that_a_log_lacks_are_left_out() {
    let full = with_status("uint64 timestamp\nuint8 nav_state\nbool failsafe\n");
    let old = with_status("uint64 timestamp\nbool failsafe\n");
    let bytes = Flight::new(&old).log().to_bytes();
    let timeline = timeline(&bytes, &full);
    let status: Vec<&str> =
        timeline.lanes.iter().filter(|lane| lane.topic == "vehicle_status").map(|lane| &*lane.name).collect();
    assert_eq!(status, ["failsafe"]);
    assert_eq!(timeline.topics(TopicStatus::Differs).collect::<Vec<_>>(), ["vehicle_status"]);
}

#[test]
fn tells_the_errors_and_modes_of_a_session() {
    let line = |time: f64, status: Json| {
        let body = json!({ "type": "UAV-INF", "status": status });
        let message = json!({ "$fw.version": "1.0", "id": "a", "body": body });
        format!("{}\n", json!({ "t": time, "conn": "tcp#1", "dir": "in", "msg": message }))
    };
    let event = |time: f64, event: &str| {
        format!("{}\n", json!({ "t": time, "conn": "tcp#1", "dir": "event", "event": event }))
    };
    let text = [
        event(1.8e9, "connect"),
        line(1.8e9 + 1.0, json!({ "7": { "errors": [1], "mode": "stab" }, "8": { "errors": [66] } })),
        line(1.8e9 + 2.0, json!({ "7": { "errors": [66, 40_000] }, "8": { "mode": "land" } })),
        line(1.8e9 + 4.0, json!({ "7": { "errors": [] } })),
        event(1.8e9 + 5.0, "closed"),
    ];
    let timeline = timeline(text.concat().as_bytes(), &Definitions::built_in());
    assert!(timeline.is_session);
    assert_eq!(timeline.start_utc.as_deref(), Some("2027-01-15T08:00:00.000Z"));
    let of = |subject: &str, name: &str| {
        let is_wanted = |lane: &&Lane| lane.subject.as_deref() == Some(subject) && lane.name == name;
        timeline.lanes.iter().find(is_wanted).unwrap_or_else(|| panic!("{subject} {name}"))
    };
    let low = of("7", "66 LOWBAT");
    assert_eq!(texts_of(&changes(low)), [(2_000_000, "set"), (4_000_000, "cleared")]);
    assert_eq!((low.set_us(), low.values[1].severity), (2_000_000, Severity::Warning));
    assert!(low.label.as_ref().is_some_and(|label| label.in_language("uk") != label.text));
    assert!(!low.changes[0].is_first, "the code wasn't in the first status");
    let ground = of("7", "1 GROUND");
    assert_eq!(texts_of(&changes(ground)), [(1_000_000, "set"), (2_000_000, "cleared")]);
    assert!(ground.changes[0].is_first);
    assert_eq!(of("7", "40000").label, None, "the code is unknown");
    // Without this field, the error codes are unknown.
    assert_eq!(texts_of(&changes(of("8", "66 LOWBAT"))), [(1_000_000, "set")]);
    assert_eq!(of("8", "66 LOWBAT").set_us(), 4_000_000);
    let modes = of("8", "mode");
    assert_eq!(modes.values[0].parts[0].label.as_ref().map(|label| &*label.text), Some("Automatic landing"));
    assert_eq!(texts_of(&changes(of("tcp#1", "connection"))), [(0, "connect"), (5_000_000, "closed")]);
    assert_eq!(timeline.topics(TopicStatus::Absent).collect::<Vec<_>>(), ["CONN-INF"]);
}

#[test]
fn bounds_the_memory_for_hostile_sessions() {
    let lines = (0..extent(3_000, 1_700)).map(|number| {
        let status = json!({ format!("uav {number}"): { "errors": [number], "mode": "x".repeat(500) } });
        let body = json!({ "type": "UAV-INF", "status": status });
        json!({ "$fw.version": "1.0", "id": "a", "body": body }).to_string()
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    let timeline = timeline(text.as_bytes(), &Definitions::built_in());
    assert!(timeline.lanes.len() <= 2_000, "{}", timeline.lanes.len());
    assert!(timeline.values_without_lane > extent(1_000, 500), "{}", timeline.values_without_lane);
    let longest = timeline.lanes.iter().flat_map(|lane| &lane.values).flat_map(|value| &value.parts);
    assert!(longest.map(|part| part.name.len()).max().is_some_and(|length| length < 200));
}

#[test]
fn an_event_without_an_id_is_no_event() {
    let event =
        json!({ "timestamp": 9, "id": 0, "event_sequence": 3, "arguments": vec![0; 25], "log_levels": 0 });
    let timeline = timeline(&lines(&[("px4/Event", event)]), &Definitions::built_in());
    assert_eq!(lane(&timeline, "event", "event").num_changes(), 0);
}

#[test]
fn recognizes_the_names_of_topics_in_captures() {
    for name in ["vehicle_status", "/fmu/out/vehicle_status", "/a/vehicle_status_v12", "px4/VehicleStatus"] {
        assert!(is_same_topic(name, "vehicle_status"), "{name}");
    }
    for name in ["vehicle_status_vx", "vehicle", "/vehicle_status/x", ""] {
        assert!(!is_same_topic(name, "vehicle_status"), "{name}");
    }
}

#[test]
fn a_file_that_is_no_capture_has_no_timeline() {
    let definitions = Definitions::built_in();
    for bytes in [&b""[..], b"not a capture", b"\x01\x02\x03\x04"] {
        assert!(Timeline::of_bytes(bytes, &definitions, &texts()).is_err(), "{bytes:?}");
    }
}

/// The topics of several vehicles have the same name.
#[test]
fn lanes_of_several_vehicles_name_the_topic() {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let topic = flight.topic("BatteryStatus").expect("a topic");
    let sent = flight.messages.iter().find(|sent| sent.topic == topic).expect("a message");
    let line = |topic: &str| format!("{}\n", json!({ "op": "publish", "topic": topic, "msg": sent.value }));
    let subjects = |topics: &[&str]| {
        let text: String = topics.iter().map(|topic| line(topic)).collect();
        let timeline = timeline(text.as_bytes(), &definitions);
        let lanes = timeline.lanes.into_iter().filter(|lane| lane.name == "warning");
        lanes.map(|lane| lane.subject).collect::<Vec<_>>()
    };
    let [a, b] = ["/a/fmu/out/battery_status", "/b/fmu/out/battery_status"];
    assert_eq!(subjects(&[a]), [None]);
    assert_eq!(subjects(&[a, b]), [Some(a.to_owned()), Some(b.to_owned())]);
}
