//! Tests of conversions of logs.

use std::collections::BTreeSet;
use std::fs;

use tempfile::TempDir;
use uavspec_capture::ulog::{Event, Reader};
use uavspec_check::convert::{Action, ConversionReport, Settings};
use uavspec_check::{Checked, FormatResult, Summary, open_path};
use uavspec_dynamic::Value;
use uavspec_rules::sample::{Entry, Log};
use uavspec_runtime::Number;
use uavspec_test_captures::head_of_log as head;
use uavspec_test_support::{extent, shared};

use super::{LIBRARY, checked, checked_against, converted, release, sample, short_flight};

/// A short flight with all topics of a release.
fn flight(label: &str) -> Log {
    short_flight(label).log()
}

/// The bytes of the messages in a log, by kind.
fn messages(bytes: &[u8], kinds: &[u8]) -> Vec<Vec<u8>> {
    let mut reader = Reader::new(bytes);
    let mut found = Vec::new();
    while let Some(item) = reader.next().expect("a slice") {
        if item.bytes.get(2).is_some_and(|kind| kinds.contains(kind))
            && !matches!(item.event, Event::Start { .. })
        {
            found.push(item.bytes.to_vec());
        }
    }
    found
}

/// The topics whose format differs from the definition.
fn differing(found: &Checked) -> Vec<&str> {
    let Summary::Log(summary) = &found.result.summary else { panic!("a log") };
    let other = summary.formats.iter().filter(|format| format.result != FormatResult::Equal);
    other.map(|format| format.topic.as_str()).collect()
}

/// The violations of all rules except the rules on valid values and queue lengths, which differ between releases.
fn violations(found: &Checked) -> BTreeSet<(&str, String)> {
    let groups = found.result.findings.groups();
    let groups =
        groups.filter(|group| !["PX-ENUM-01", "PX-QUEUE-01", "PX-RANGE-01"].contains(&group.rule.id));
    groups.map(|group| (group.rule.id, group.subject.clone())).collect()
}

fn topics(report: &ConversionReport, action: Action) -> Vec<&str> {
    let topics = report.topics.iter().filter(|topic| topic.action == action);
    topics.map(|topic| topic.topic.as_str()).collect()
}

#[test]
fn converted_logs_agree_with_the_target_release() {
    let pairs = [("1.16", "1.17"), ("1.17", "1.16"), ("1.13", "1.18"), ("main", "1.14")];
    for (from, to) in pairs.into_iter().step_by(extent(1, 2)) {
        let (from, to) = (format!("px4@{from}"), format!("px4@{to}"));
        let log = sample(&from).log();
        let bytes = log.to_bytes();
        let (report, output) = converted(&bytes, &to, Settings::default());
        assert!(report.is_complete(), "{:?}", report.problems);
        assert_eq!(report.from, [from.as_str()]);
        assert!(report.count(Action::Converted) > extent(100, 15) && report.count(Action::Copied) == 0);
        let left_out = report.topics.iter().filter(|topic| topic.action == Action::LeftOut);
        assert!(left_out.clone().all(|topic| topic.reason.is_some()));
        let left_out: u64 = left_out.map(|topic| topic.messages).sum();
        let found = checked(&output);
        assert_eq!(found.result.summary.releases()[0].release, to);
        let target = release(&to);
        let names = report.topics.iter().filter(|topic| topic.action == Action::Converted);
        let names = names.map(|topic| topic.renamed.as_deref().unwrap_or(&topic.topic));
        // A topic keeps its name if several topics of the target replace it.
        let other: BTreeSet<&str> =
            names.filter(|name| target.base().message_of_topic(name).is_none()).collect();
        assert!(other.len() <= 6, "{other:?}");
        let after = checked_against(&output, target);
        assert_eq!(differing(&after).into_iter().collect::<BTreeSet<_>>(), other);
        assert_eq!(found.result.corruption, []);
        let all = log.entries.iter().filter(|entry| matches!(entry, Entry::Data(..))).count() as u64;
        assert_eq!(found.result.records, all - left_out);
        assert_eq!(violations(&found), BTreeSet::new(), "{from} {to}");
        assert_eq!(messages(&output, b"IMPQLCSO"), messages(&bytes, b"IMPQLCSO"));
    }
}

#[test]
fn a_log_of_the_target_release_stays_the_same() {
    let bytes = flight("px4@1.16").to_bytes();
    let (report, output) = converted(&bytes, "px4@1.16", Settings::default());
    assert!(report.topics.iter().all(|topic| topic.renamed.is_none() && topic.losses.is_empty()));
    for kinds in [&b"BIPASO"[..], b"D"] {
        assert!(messages(&output, kinds) == messages(&bytes, kinds));
    }
    let formats = |bytes| messages(bytes, b"F").into_iter().collect::<BTreeSet<_>>();
    assert!(formats(&output) == formats(&bytes));
}

#[test]
fn real_logs_agree_with_each_release() {
    let releases = ["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"];
    let Some(logs) = shared("corpus/ulog") else { return };
    let entries = fs::read_dir(logs).expect("a folder");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a log").path()).collect();
    paths.sort();
    // In quick mode, the test converts only the start of every second log, to one of the releases.
    for (at, path) in paths.iter().enumerate().skip(extent(0, 1)).step_by(extent(1, 2)) {
        let whole = fs::read(path).expect("a log");
        let bytes = head(&whole, extent(usize::MAX, 120_000));
        let before = checked(bytes);
        for to in releases.iter().skip(extent(0, 2 * at)).step_by(extent(1, 7)) {
            let to = format!("px4@{to}");
            let (report, output) = converted(bytes, &to, Settings::default());
            let (name, is_whole) = (path.display(), before.result.corruption.is_empty());
            assert_eq!(report.is_complete(), is_whole, "{name} {to}: {:?}", report.problems);
            assert!(report.count(Action::Converted) > 1, "{name} {to}");
            let target = release(&to);
            let after = checked_against(&output, target);
            assert_eq!(after.result.corruption.len(), 0, "{name} {to}");
            let new: Vec<_> = violations(&after).difference(&violations(&before)).cloned().collect();
            assert_eq!(new, [], "{name} {to}");
            let copied = topics(&report, Action::Copied);
            let is_known = |topic: &&str| target.base().message_of_topic(topic).is_some();
            let other = differing(&after).into_iter().filter(|topic| !copied.contains(topic));
            let other: Vec<_> = other.filter(is_known).collect();
            assert_eq!(other, Vec::<&str>::new(), "{name} {to}");
            let left_out = report.topics.iter().filter(|topic| topic.action == Action::LeftOut);
            let missing: u64 = left_out.map(|topic| topic.messages).sum();
            let unreadable: u64 = report.topics.iter().map(|topic| topic.unreadable).sum();
            assert_eq!(after.result.records + missing + unreadable, before.result.records, "{name} {to}");
            let others = b"IMPQLCSO";
            assert!(messages(&output, others) == messages(bytes, others), "{name} {to}");
        }
    }
}

#[test]
fn messages_have_no_padding_at_the_end() {
    let log = flight("px4@1.17");
    let (_, output) = converted(&log.to_bytes(), "px4@1.16", Settings::default());
    let target = release("px4@1.16");
    let definitions = target.base();
    let mut reader = Reader::new(&output[..]);
    let mut log = uavspec_capture::ulog::Log::default();
    let mut converted = 0;
    while let Some(item) = reader.next().expect("a slice") {
        let Some(record) = log.take(&item, &mut |_, problem| panic!("{problem}")) else { continue };
        let id = definitions.message_of_topic(&record.subscription.topic).expect("a topic");
        let size = definitions.types().get(id).size().expect("a size");
        let is_copied = record.payload.len() == size.padded;
        assert!(is_copied || record.payload.len() == size.no_padding);
        converted += usize::from(!is_copied);
    }
    assert!(converted > 10, "{converted}");
}

/// The log contains a custom topic with a nested PX4 message, whose fields differ between the releases.
#[test]
fn other_topics_keep_their_formats_and_nested_types() {
    let mut log = flight("px4@1.13");
    let report = log.format_mut("esc_report").expect("a format").clone();
    let at = log
        .entries
        .iter()
        .position(|entry| matches!(entry, Entry::Subscription(..)))
        .expect("a subscription");
    let id = 9_000;
    log.entries.splice(
        at..at,
        [
            Entry::Format(
                "winch".to_owned(),
                "uint64_t timestamp;esc_report[2] motors;hook rope;".to_owned(),
            ),
            Entry::Format("hook".to_owned(), "esc_report motor;uint64_t length;".to_owned()),
            Entry::Subscription(id, 0, "winch".to_owned()),
        ],
    );
    let library = release("px4@1.13");
    let esc_report = library.base().message_of_topic("esc_report").expect("a topic");
    let size = library.base().types().get(esc_report).size().expect("a size").padded;
    let payload: Vec<u8> = (0..=255).take(8 + 3 * size + 8).collect();
    log.entries.push(Entry::Data(id, payload.clone()));
    let bytes = log.to_bytes();
    assert_eq!(checked(&bytes).result.corruption, []);
    let (report_of, output) = converted(&bytes, "px4@1.18", Settings::default());
    assert!(report_of.is_complete(), "{:?}", report_of.problems);
    assert_eq!(topics(&report_of, Action::Copied), ["winch"]);
    let formats: Vec<String> = messages(&output, b"F")
        .into_iter()
        .map(|bytes| String::from_utf8(bytes[3..].to_vec()).expect("text"))
        .collect();
    let has = |text: &str| formats.iter().any(|format| format == text);
    assert!(has("winch:uint64_t timestamp;esc_report_unconverted1[2] motors;hook rope;"), "{formats:?}");
    assert!(has("hook:esc_report_unconverted1 motor;uint64_t length;"));
    assert!(has(&format!("esc_report_unconverted1:{report}")));
    assert!(formats.iter().any(|format| format.starts_with("esc_report:") && !format.ends_with(&report)));
    let data = messages(&output, b"D").pop().expect("data");
    assert_eq!(data[5..], payload);
    let found = checked(&output);
    assert_eq!(found.result.corruption, []);
    assert!(differing(&found).contains(&"winch"));
}

#[test]
fn formats_that_differ_from_all_releases_are_left_out() {
    let mut log = flight("px4@1.17");
    log.format_mut("battery_status").expect("a format").push_str("uint64_t cells_of_the_club;");
    let at = log
        .entries
        .iter()
        .position(|entry| matches!(entry, Entry::Subscription(_, _, topic) if topic == "battery_status"));
    let Some(Entry::Subscription(id, ..)) = at.map(|at| log.entries[at].clone()) else {
        panic!("a subscription")
    };
    for entry in &mut log.entries {
        match entry {
            Entry::Data(known, payload) if *known == id => payload.extend([7; 8]),
            _ => {}
        }
    }
    let (report, output) = converted(&log.to_bytes(), "px4@1.16", Settings::default());
    let topic = report.topics.iter().find(|topic| topic.topic == "battery_status").expect("the topic");
    assert_eq!(
        (topic.action, topic.reason.as_deref()),
        (Action::LeftOut, Some("its fields differ from PX4 1.17"))
    );
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(!messages(&output, b"FA").iter().any(|message| text(message).contains("battery_status")));
    let (report, output) =
        converted(&log.to_bytes(), "px4@1.16", Settings { keeps_unconverted: true, ..Settings::default() });
    assert_eq!(report.count(Action::LeftOut), 0);
    assert!(messages(&output, b"F").iter().any(|message| text(message).contains("cells_of_the_club")));
    let found = checked(&output);
    assert_eq!(found.result.corruption, []);
    assert_eq!(
        found.result.records,
        log.entries.iter().filter(|entry| matches!(entry, Entry::Data(..))).count() as u64
    );
}

/// The topic exists only in the target release.
#[test]
fn other_topics_with_a_name_of_the_target_are_left_out() {
    let mut log = flight("px4@1.16");
    let at = log
        .entries
        .iter()
        .position(|entry| matches!(entry, Entry::Subscription(..)))
        .expect("a subscription");
    let topic = "battery_info";
    let entries = [
        Entry::Format(topic.to_owned(), "uint64_t timestamp;uint64_t cells;".to_owned()),
        Entry::Subscription(9_000, 0, topic.to_owned()),
    ];
    log.entries.splice(at..at, entries);
    log.entries.push(Entry::Data(9_000, vec![7; 16]));
    for (to, action) in [("px4@1.17", Action::LeftOut), ("px4@1.15", Action::Copied)] {
        let (report, _) = converted(&log.to_bytes(), to, Settings::default());
        let found = report.topics.iter().find(|found| found.topic == topic).expect("the topic");
        assert_eq!(found.action, action, "{found:?}");
    }
}

/// PX4 1.13 has a separate message for each topic. Later releases share a message between several topics.
#[test]
fn topics_with_a_message_of_several_topics_are_converted() {
    let (report, output) = converted(&flight("px4@1.13").to_bytes(), "px4@1.15", Settings::default());
    let positions = ["vehicle_gps_position", "estimator_attitude", "vehicle_local_position_groundtruth"];
    for topic in positions {
        let found = report.topics.iter().find(|found| found.topic == topic).expect("the topic");
        assert_eq!(found.action, Action::Converted, "{found:?}");
    }
    // The position has other units.
    let (mut reader, mut log) = (Reader::new(&output[..]), uavspec_capture::ulog::Log::default());
    while let Some(item) = reader.next().expect("a slice") {
        let Some(record) = log.take(&item, &mut |_, problem| panic!("{problem}")) else { continue };
        if record.subscription.topic == positions[0] {
            let view = record.message_type.view_uorb(record.payload).expect("a message");
            let latitude = view.get("latitude_deg").and_then(Value::number);
            assert!(
                matches!(latitude, Some(Number::Float(value)) if value != 0.0 && value.abs() < 90.0),
                "{latitude:?}"
            );
        }
    }
}

#[test]
fn topics_get_the_name_of_the_target() {
    let (report, output) = converted(&flight("px4@1.17").to_bytes(), "px4@1.18", Settings::default());
    let topic = report.topics.iter().find(|topic| topic.topic == "gps_inject_data").expect("the topic");
    assert_eq!((topic.action, topic.renamed.as_deref()), (Action::Converted, Some("rtcm_corrections")));
    assert!(messages(&output, b"A").iter().any(|message| message.ends_with(b"rtcm_corrections")));
}

/// PX4 logs can end with data that was appended after a crash.
#[test]
fn appended_data_follows_the_other_data() {
    let log = flight("px4@1.17");
    let mut bytes = log.to_bytes();
    let (_, expected) = converted(&bytes, "px4@1.16", Settings::default());
    let whole = bytes.len();
    let last = messages(&bytes, b"D").pop().expect("data");
    let appended = whole - last.len();
    // The logger was interrupted within a message.
    bytes.splice(appended..appended, [40, 0, b'D', 1]);
    let (flags, offset) = (16 + 3 + 8, 16 + 3 + 16);
    bytes[flags] |= 1;
    bytes[offset..offset + 8].copy_from_slice(&(appended as u64 + 4).to_le_bytes());
    assert_eq!(messages(&bytes, b"D").len(), messages(&log.to_bytes(), b"D").len());
    let (report, output) = converted(&bytes, "px4@1.16", Settings::default());
    assert!(output == expected);
    assert!(report.problems.iter().any(|problem| problem.contains("appended")), "{:?}", report.problems);
}

#[test]
fn readable_messages_of_a_truncated_log_are_converted() {
    let bytes = sample("px4@1.16").log().to_bytes();
    let first_data = bytes.len() - messages(&bytes, b"D").concat().len();
    for cut in [9, 30, 100, 2_000, first_data, first_data + 1, bytes.len() * 9 / 10, bytes.len() - 1] {
        let (report, output) = converted(&bytes[..cut], "px4@1.17", Settings::default());
        assert_eq!(report.is_complete(), cut == first_data, "{cut}: {:?}", report.problems);
        if cut > first_data + 1 {
            let found = checked(&output).result;
            assert_eq!(found.corruption, [], "{cut}");
            assert!(found.records > 0);
        }
    }
}

#[test]
fn corrupt_logs_are_converted_as_far_as_they_can_be_read() {
    let bytes = flight("px4@1.17").to_bytes();
    let (_, whole) = converted(&bytes, "px4@1.16", Settings::default());
    for seed in (1..20_usize).step_by(extent(1, 18)) {
        let mut damaged = bytes.clone();
        for step in 1..6 {
            let at = (seed * 7_919 * step * step + 40 * seed) % damaged.len();
            damaged[at] ^= 1 << (seed % 8);
            damaged[(at / 3).max(16)] = 0xff;
        }
        let (report, output) = converted(&damaged, "px4@1.16", Settings::default());
        assert!(output.len() < 2 * whole.len(), "{seed}");
        let text = report.to_text();
        assert!(!text.chars().any(|character| character.is_control() && character != '\n'), "{text}");
        if let Summary::Log(_) = &checked(&output).result.summary {
            // The output has no corrupt framing.
            let mut reader = Reader::new(&output[..]);
            while let Some(item) = reader.next().expect("a slice") {
                let is_copied =
                    matches!(&item.event, Event::Problem(problem) if problem.to_string().contains("message"));
                assert!(!matches!(item.event, Event::Problem(_)) || is_copied, "{seed}: {:?}", item.event);
            }
        }
    }
}

/// The log's firmware may contain messages of another release.
#[test]
fn topics_of_another_release_are_converted() {
    let (mut log, other) = (flight("px4@1.16"), flight("px4@1.15"));
    let topic = "airspeed";
    let subscribed = |log: &Log| {
        log.entries.iter().find_map(|entry| match entry {
            Entry::Subscription(id, _, name) if name == topic => Some(*id),
            _ => None,
        })
    };
    let (id, other_id) = (subscribed(&log).expect("a topic"), subscribed(&other).expect("a topic"));
    let other_data = other.entries.iter().find_map(|entry| match entry {
        Entry::Data(id, payload) if *id == other_id => Some(payload.clone()),
        _ => None,
    });
    let fields = other.clone().format_mut(topic).expect("a format").clone();
    *log.format_mut(topic).expect("a format") = fields;
    for entry in &mut log.entries {
        match entry {
            Entry::Data(known, payload) if *known == id => {
                payload.clone_from(other_data.as_ref().expect("data"));
            }
            _ => {}
        }
    }
    let (report, output) = converted(&log.to_bytes(), "px4@1.17", Settings::default());
    let found = report.topics.iter().find(|found| found.topic == topic).expect("the topic");
    let expected = (Action::Converted, Some("px4@1.15"), 0);
    assert_eq!((found.action, found.from.as_deref(), found.unreadable), expected, "{found:?}");
    assert_eq!(differing(&checked_against(&output, release("px4@1.17"))), Vec::<&str>::new());
}

#[test]
fn encrypted_logs_are_rejected() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("in.ulge");
    fs::write(&path, b"ULogEnc\x01rest of the log").expect("a file");
    let reason =
        open_path(&path, &LIBRARY, &|input| input).expect("a file").map(|_| ()).expect_err("a reason");
    assert!(reason.contains("encrypted"), "{reason}");
}
