//! Tests of the events of services.

use std::fs;

use super::{assert_same, checked_with, corrupt, summary, violated};
use crate::check::check_capture;
use crate::check::{Basis, CheckStatus};
use crate::definitions::{Definitions, Library};
use crate::fuzzing::bag_file::Content;
use crate::px4::comparison::Comparison;
use crate::tests::mcap::file as mcap;
use crate::tests::support::shared;

const SOAR: &str = "uint8 height\nbool is_fast\n---\nint16 climbed\n";

/// Definitions of a service.
fn definitions(dialect: &str, package: &str, name: &str, text: &str) -> Definitions {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("srv")).expect("a folder");
    fs::write(folder.path().join(format!("srv/{name}.srv")), text).expect("a file");
    let config =
        format!("[[package]]\nname = \"{package}\"\ndialect = \"{dialect}\"\ninclude = [\"srv/*.srv\"]\n");
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    Definitions::load(&folder.path().join("uavspec.toml")).expect("definitions")
}

/// An event with a request and no response, in CDR.
fn event(is_fast: u8) -> Vec<u8> {
    let info = [&[1, 0, 0, 0][..], &7_i32.to_le_bytes(), &8_u32.to_le_bytes(), &[5; 16]].concat();
    let request = [&1_u32.to_le_bytes()[..], &[40, is_fast, 0, 0]].concat();
    // The header isn't part of the alignment.
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
    let hash = crate::rules::rule("PX-HASH-01").expect("a rule");
    assert_eq!(
        result.findings.covered(hash),
        5,
        "two hashes of a service, and three of messages with their own schema"
    );
}
