//! Tests of the messages that ROS 2 derives from services and actions.

use std::fs;

use uavspec_check::{Basis, CheckStatus, check_capture};
use uavspec_px4::comparison::Comparison;
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_test_captures::mcap;
use uavspec_test_captures::rosbag::Content;
use uavspec_test_support::{extent, shared};

use super::{FIXED, assert_same, checked_with, corrupt, summary, violated};

const SOAR: &str = "uint8 height\nbool is_fast\n---\nint16 climbed\n";

/// Definitions of a service.
fn definitions(dialect: &str, package: &str, name: &str, text: &str) -> Definitions {
    definitions_of("srv", dialect, package, name, text)
}

/// Definitions of a service or an action.
fn definitions_of(kind: &str, dialect: &str, package: &str, name: &str, text: &str) -> Definitions {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join(kind)).expect("a folder");
    fs::write(folder.path().join(format!("{kind}/{name}.{kind}")), text).expect("a file");
    let config = format!(
        "[[package]]\nname = \"{package}\"\ndialect = \"{dialect}\"\ninclude = [\"{kind}/*.{kind}\"]\n"
    );
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    Definitions::load(&folder.path().join("uavspec.toml")).expect("definitions")
}

/// An event with a request and no response, in CDR.
fn event(is_fast: u8) -> Vec<u8> {
    let info = [&[1, 0, 0, 0][..], &7_i32.to_le_bytes(), &8_u32.to_le_bytes(), &[5; 16]].concat();
    let request = [&1_u32.to_le_bytes()[..], &[40, is_fast, 0, 0]].concat();
    // The header doesn't count for the alignment.
    let mut body = info;
    body.resize(body.len().next_multiple_of(8), 0);
    body.extend(9_i64.to_le_bytes());
    [&[0, 1, 0, 0][..], &body, &request, &0_u32.to_le_bytes()].concat()
}

#[test]
fn events_of_known_services_are_known() {
    for dialect in ["ros2", "px4"] {
        let definitions = definitions(dialect, "sky_msgs", "Soar", SOAR);
        for (text, is_fast, expected) in [
            (SOAR, 1, vec![]),
            ("", 1, vec![]),
            (SOAR, 7, vec!["PX-BOOL-01"]),
            ("uint8 height\nbool is_slow\n---\nint16 climbed\n", 1, vec!["PX-FMT-01"]),
        ] {
            let records = [
                mcap::schema(1, "sky_msgs/srv/Soar_Event", "ros2msg", text.as_bytes()),
                mcap::channel(3, 1, "/soar/_service_event", "cdr", &[]),
                mcap::message(3, &event(is_fast)),
            ];
            let bytes = mcap::file(&records.concat());
            let result = check_capture(&bytes[..], None, &definitions).expect("bytes");
            let found: Vec<_> = violated(&result).into_iter().map(|(rule, ..)| rule).collect();
            let name = format!("{dialect}: {text:?} {is_fast}");
            assert_eq!((found, corrupt(&result), result.checked), (expected, vec![], 1), "{name}");
            let twin = Content::of_mcap(&bytes).to_bytes();
            let twin = check_capture(&twin[..], None, &definitions).expect("bytes");
            assert_same(&twin, &result, &name);
        }
    }
}

#[test]
fn events_of_unknown_services_have_no_definition() {
    let definitions = definitions("ros2", "sky_msgs", "Soar", SOAR);
    for name in ["sky_msgs/srv/Sink_Event", "sky_msgs/msg/Soar_Event", "other_msgs/srv/Soar_Event"] {
        assert_eq!(definitions.message_of_type(name), None, "{name}");
    }
    for name in ["sky_msgs/srv/Soar_Event", "sky_msgs/srv/Soar_Request", "sky_msgs/srv/Soar_Response"] {
        assert!(definitions.message_of_type(name).is_some(), "{name}");
    }
}

/// A recording of rosbag2's own tests. `SQLite` files contain the name of the service and its text.
#[test]
fn reads_recorded_events() {
    let Some(bags) = shared("corpus/bags") else { return };
    let bag = bags.join("sqlite3/bag_with_topics_and_service_events/bag_with_topics_and_service_events.db3");
    let file = rusqlite::Connection::open_with_flags(&bag, rusqlite::OpenFlags::SQLITE_OPEN_READ_ONLY)
        .expect("a bag");
    let query = "SELECT encoded_message_definition FROM message_definitions WHERE topic_type = 'test_msgs/srv/BasicTypes'";
    let text: String = file.query_row(query, [], |row| row.get(0)).expect("a definition");
    let definitions = definitions("ros2", "test_msgs", "BasicTypes", &text);
    let result = checked_with(&bag, &Library::fixed(definitions));
    assert_eq!((violated(&result), corrupt(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (10, 10));
    let equal = CheckStatus::Checked(Basis::Compared(Comparison::Equal.into()));
    assert_eq!(summary(&result).channels.iter().filter(|channel| channel.status == equal).count(), 2);
    let own = summary(&result).channels.iter().filter(|channel| channel.status == CheckStatus::OwnSchema);
    assert_eq!(own.count(), 3);
    let hash = uavspec_rules::rule("PX-HASH-01").expect("a rule");
    assert_eq!(
        result.findings.covered(hash),
        5,
        "two hashes of a service, and three of messages with their own schema"
    );
}

/// The schema that rosbag2 records for a type that ROS 2 derives from a service or an action. `word` marks the kind of
/// text.
fn marked(word: &str, name: &str, text: &str) -> String {
    format!("{}\n{word}: {name}\n{text}", "=".repeat(80))
}

/// Checks a message both as an MCAP file and as a `SQLite` file. Returns the violated rules and the numbers of
/// messages.
fn checked_both(
    ty: &str,
    text: &str,
    payload: &[u8],
    definitions: &Definitions,
) -> (Vec<&'static str>, u64, u64) {
    let records = [
        mcap::schema(1, ty, "ros2msg", text.as_bytes()),
        mcap::channel(3, 1, "/soar/topic", "cdr", &[]),
        mcap::message(3, payload),
    ];
    let bytes = mcap::file(&records.concat());
    let result = check_capture(&bytes[..], None, definitions).expect("bytes");
    let twin = Content::of_mcap(&bytes).to_bytes();
    let twin = check_capture(&twin[..], None, definitions).expect("bytes");
    assert_same(&twin, &result, &format!("{ty}: {text}"));
    assert_eq!(corrupt(&result), Vec::<String>::new());
    (violated(&result).into_iter().map(|(rule, ..)| rule).collect(), result.records, result.checked)
}

#[test]
fn the_text_of_a_service_may_follow_its_name() {
    let known = definitions("ros2", "sky_msgs", "Soar", SOAR);
    let marked = marked("SRV", "sky_msgs/srv/Soar", SOAR);
    let built_in: &Definitions = FIXED.base();
    for definitions in [&known, built_in] {
        for (text, is_fast, expected) in
            [(SOAR, 1, vec![]), (&marked, 1, vec![]), (&marked, 7, vec!["PX-BOOL-01"])]
        {
            let found = checked_both("sky_msgs/srv/Soar_Event", text, &event(is_fast), definitions);
            assert_eq!(found, (expected, 1, 1), "{text:?} {is_fast}");
        }
    }
}

const LAND: &str = "bool is_soft\n---\nbool is_down\n---\nbool is_low\n";

/// The types that ROS 2 derives from an action. Each has a message whose last byte is a bool that the action defines.
fn of_action(last: u8) -> Vec<(&'static str, Vec<u8>)> {
    let header = [0, 1, 0, 0];
    let uuid = [3; 16];
    let info = [&[1, 0, 0, 0][..], &7_i32.to_le_bytes(), &8_u32.to_le_bytes(), &[5; 16]].concat();
    let info = [&info[..], &[0; 4], &9_i64.to_le_bytes()].concat();
    let one = 1_u32.to_le_bytes();
    let none = 0_u32.to_le_bytes();
    [
        ("Goal", vec![last]),
        ("Result", vec![last]),
        ("Feedback", vec![last]),
        ("FeedbackMessage", [&uuid[..], &[last]].concat()),
        ("SendGoal_Request", [&uuid[..], &[last]].concat()),
        ("SendGoal_Response", [&[last][..], &[0; 3], &one, &one].concat()),
        ("SendGoal_Event", [&info[..], &one, &uuid, &[last, 0, 0, 0], &none].concat()),
        ("GetResult_Request", uuid.to_vec()),
        ("GetResult_Response", vec![4, last]),
        ("GetResult_Event", [&info[..], &none, &one, &[4, last]].concat()),
    ]
    .map(|(suffix, body)| (suffix, [&header[..], &body].concat()))
    .into()
}

#[test]
fn types_of_actions_are_known() {
    let known = definitions_of("action", "ros2", "sky_msgs", "Land", LAND);
    let built_in: &Definitions = FIXED.base();
    let marked = marked("ACTION", "sky_msgs/action/Land", LAND);
    for (definitions, text) in
        [(&known, ""), (&known, LAND), (&known, &marked), (built_in, LAND), (built_in, &marked)]
    {
        // In quick mode, each type is tested with only one of the values.
        for (first, last) in [(0, 1), (1, 7)] {
            let messages = of_action(last).into_iter().skip(extent(0, first)).step_by(extent(1, 2));
            for (suffix, payload) in messages {
                let has_bool = suffix != "GetResult_Request";
                let expected = if last == 7 && has_bool { vec!["PX-BOOL-01"] } else { vec![] };
                let found =
                    checked_both(&format!("sky_msgs/action/Land_{suffix}"), text, &payload, definitions);
                assert_eq!(found, (expected, 1, 1), "{suffix} {text:?} {last}");
            }
        }
    }
}

/// `SQLite` files of rosbag2 contain the action under its own name.
#[test]
fn the_definition_of_an_action_defines_its_types() {
    let [(_, feedback), (_, goal)] = [3, 6].map(|at| of_action(1)[at].clone());
    let types = ["FeedbackMessage", "SendGoal_Event"].map(|suffix| format!("sky_msgs/action/Land_{suffix}"));
    let topic =
        |id: i64, ty: &str| (id, [format!("/land/{id}"), ty.to_owned(), "cdr".to_owned(), String::new()]);
    let content = Content {
        definitions: vec![["sky_msgs/action/Land", "ros2msg", LAND, ""].map(str::to_owned)],
        topics: vec![topic(1, &types[0]), topic(2, &types[1])],
        messages: vec![(1, 1, feedback), (2, 2, goal)],
        ..Content::default()
    };
    let result = check_capture(&content.to_bytes()[..], None, FIXED.base()).expect("bytes");
    assert_eq!((violated(&result), corrupt(&result), result.checked), (vec![], vec![], 2));
}

#[test]
fn names_the_reason_why_a_schema_is_not_used() {
    let line = "=".repeat(80);
    let idl = format!("{line}\nIDL: sky_msgs/msg/Line\nmodule sky_msgs {{ }};\n");
    let rope = "rope_msgs/Rope rope\n";
    for (encoding, text, expected) in [
        ("ros2msg", rope, "invalid schema: sky_msgs/Line.msg:1: the inputs contain no package `rope_msgs`"),
        ("ros2msg", "float32 length!\n", "invalid schema: sky_msgs/Line.msg:1: "),
        ("ros2msg", &idl, "invalid schema: it contains IDL, which isn't supported"),
        ("ros2msg", "sky_msgs/msg/Line\n", "the schema contains only the name of the type"),
        ("ros2idl", &idl, "the schema encoding `ros2idl` isn't supported"),
        ("jsonschema", "{}", "the schema encoding `jsonschema` isn't supported"),
        ("protobuf", "\u{1}", "the schema encoding `protobuf` isn't supported"),
        ("", "", "no schema with fields"),
    ] {
        let records = [
            mcap::schema(1, "sky_msgs/msg/Line", encoding, text.as_bytes()),
            mcap::channel(3, 1, "/line", "cdr", &[]),
            mcap::message(3, &[0, 1, 0, 0, 0, 0, 0, 0]),
        ];
        let bytes = mcap::file(&records.concat());
        let twin = Content::of_mcap(&bytes).to_bytes();
        for bytes in [bytes, twin] {
            let result = check_capture(&bytes[..], None, FIXED.base()).expect("bytes");
            let json = serde_json::to_value(&result.summary).expect("JSON");
            let row = &json["channels"][0];
            let message = row["message"].as_str().expect("a message");
            assert!(row["result"] == "undefined" && message.starts_with(expected), "{encoding}: {row}");
            assert_eq!(result.checked, 0);
        }
    }
}

#[test]
fn missing_standard_types_are_those_of_ros_2() {
    let header = [&1_i32.to_le_bytes()[..], &2_u32.to_le_bytes(), &1_u32.to_le_bytes(), &[0]].concat();
    let payload = [&[0, 1, 0, 0][..], &header, &[7]].concat();
    let found =
        checked_both("sky_msgs/msg/Line", "std_msgs/Header header\nbool is_long\n", &payload, FIXED.base());
    assert_eq!(found, (vec!["PX-BOOL-01"], 1, 1));
}

/// A schema that contains only the name of its type has the same effect as a missing schema.
#[test]
fn a_schema_may_be_only_the_name_of_the_type() {
    let definitions = definitions("ros2", "sky_msgs", "Soar", SOAR);
    for text in ["", "sky_msgs/srv/Soar_Event", "sky_msgs/srv/Soar_Event\n"] {
        let found = checked_both("sky_msgs/srv/Soar_Event", text, &event(7), &definitions);
        assert_eq!(found, (vec!["PX-BOOL-01"], 1, 1), "{text}");
    }
}
