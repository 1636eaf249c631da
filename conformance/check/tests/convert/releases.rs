//! Properties of conversions between all neighbouring releases.

use std::collections::BTreeMap;

use serde_json::Value;
use uavspec_capture::mcap::{Event, Reader};
use uavspec_check::convert::{Action, ConversionReport, Settings, TopicReport};
use uavspec_check::definition_of;
use uavspec_rules::sample::BagChannel;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_test_support::extent;

use super::{checked, converted, flight_with, release};

/// The releases of PX4, in order.
const RELEASES: [&str; 7] =
    ["px4@1.13", "px4@1.14", "px4@1.15", "px4@1.16", "px4@1.17", "px4@1.18", "px4@main"];

/// The pairs of neighbouring releases, in both directions. In quick mode, one pair for each direction.
fn neighbours() -> impl Iterator<Item = (&'static str, &'static str)> {
    let pairs = RELEASES.windows(2).map(|pair| (pair[0], pair[1]));
    let both = pairs.flat_map(|(old, new)| [(old, new), (new, old)]);
    both.skip(extent(0, 6)).step_by(extent(1, 5))
}

/// A bag of a short flight. In quick mode, it contains only the topics whose messages differ between the releases, and
/// every eighth of the other topics.
fn bag_between(from: &str, to: &str) -> Vec<u8> {
    let hash = |label: &str, topic: &str| {
        let definitions = release(label).base();
        definitions.message_of_topic(topic).map(|id| definitions.schema.message(id).type_hash.clone())
    };
    let differs = |topic: &str| hash(from, topic) != hash(to, topic);
    flight_with(from, |at, topic| (at + 1).is_multiple_of(extent(1, 8)) || differs(topic)).bag().to_bytes()
}

/// The name of a topic without a namespace.
fn plain(topic: &str) -> &str {
    topic.rsplit('/').next().unwrap_or(topic)
}

/// The topics of a report by their names in the output.
fn by_output(report: &ConversionReport) -> BTreeMap<&str, &TopicReport> {
    let converted = report.topics.iter().filter(|topic| topic.action == Action::Converted);
    converted.map(|topic| (plain(topic.renamed.as_deref().unwrap_or(&topic.topic)), topic)).collect()
}

#[test]
fn only_unchecked_fields_of_converted_bags_violate_the_target_release() {
    for (from, to) in neighbours() {
        let (report, output) = converted(&bag_between(from, to), to, Settings::default());
        assert!(report.is_complete(), "{:?}", report.problems);
        let found = checked(&output);
        let releases = found.result.summary.releases();
        assert_eq!((releases.len(), releases[0].release.as_str()), (1, to), "{from}");
        let topics = by_output(&report);
        for group in found.result.findings.groups() {
            let (topic, path) = group.subject.split_once('.').expect("a field of a topic");
            let field = path.split(['.', '[']).next().expect("a field");
            let unchecked = &topics[plain(topic)].unchecked;
            assert!(unchecked.iter().any(|name| name == field), "{from} to {to}: {}", group.subject);
        }
    }
}

/// The messages of a bag as JSON, by topic. `label` is the release of the bag.
fn messages(bytes: &[u8], label: &str) -> BTreeMap<String, Vec<Value>> {
    let definitions = release(label).base();
    let (mut topics, mut schemas) = (BTreeMap::new(), BTreeMap::new());
    let mut found = BTreeMap::<String, Vec<Value>>::new();
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().expect("memory") {
        match item.event {
            Event::Schema { id, name, encoding, .. } => _ = schemas.insert(id, (name, encoding)),
            Event::Channel { id, schema, topic, .. } => {
                let (name, encoding) = &schemas[&schema];
                let message = definition_of(&topic, Some((name, encoding)), definitions);
                topics.insert(id, (plain(&topic).to_owned(), message.expect("a PX4 message")));
            }
            Event::Message { channel, payload, .. } => {
                let (topic, message) = &topics[&channel];
                let decoded = definitions.types().get(*message).decode_cdr(payload).expect("a message");
                // JSON can't represent infinite floats.
                if let Ok(value) = decoded.to_json() {
                    found.entry(topic.clone()).or_default().push(value);
                }
            }
            _ => {}
        }
    }
    found
}

/// The losses of a topic, as text.
fn losses(topic: &TopicReport) -> String {
    topic.losses.iter().map(|loss| format!("{}\n", loss.text)).collect()
}

#[test]
fn a_conversion_and_its_reverse_lose_only_what_they_report() {
    for (from, to) in neighbours() {
        let bytes = bag_between(from, to);
        let (there, between) = converted(&bytes, to, Settings::default());
        let (back, output) = converted(&between, from, Settings::default());
        let (before, after) = (messages(&bytes, from), messages(&output, from));
        let (there, back) = (by_output(&there), by_output(&back));
        assert!(after.len() > extent(100, 20), "{from} to {to}: {}", after.len());
        for (topic, values) in after {
            let second = back[&*topic];
            let first = there[plain(&second.topic)];
            let lost = losses(first) + &losses(second);
            let Some(expected) = before.get(plain(&first.topic)) else { panic!("{topic}") };
            assert_eq!(values.len(), expected.len());
            for (value, expected) in values.iter().zip(expected) {
                for (name, value) in value.as_object().expect("a message") {
                    let is_lost = lost.contains(&format!("`{name}`"));
                    assert!(is_lost || *value == expected[name], "{from} to {to}: {topic}.{name}: {lost}");
                }
            }
        }
    }
}

#[test]
fn parts_and_events_of_services_are_converted() {
    let (from, to) = ("px4@1.17", "px4@1.18");
    let library = release(from);
    for (part, topic) in [
        ("VehicleCommand_Event", "/fmu/vehicle_command/_service_event"),
        ("VehicleCommand_Request", "rq/fmu/vehicle_commandRequest"),
        ("VehicleCommand_Response", "rr/fmu/vehicle_commandReply"),
    ] {
        let name = format!("px4_msgs/srv/{part}");
        let id = library.base().message_of_type(&name).expect("a part of a service");
        let message = library.base().types().get(id).default();
        let payload = message.to_cdr(ByteOrder::LittleEndian).expect("a payload");
        let mut bag = flight_with(from, |at, _| (at + 1).is_multiple_of(extent(1, 8))).bag();
        let channel = u16::try_from(bag.channels.len()).expect("an id");
        bag.channels.push(BagChannel {
            topic: topic.to_owned(),
            schema: name.clone(),
            text: String::new(),
            hash: String::new(),
        });
        bag.messages.push((channel, 9, payload));
        let (report, output) = converted(&bag.to_bytes(), to, Settings::default());
        let found = report.topics.iter().find(|found| found.topic == topic).expect("the topic");
        assert_eq!((found.action, &found.reason), (Action::Converted, &None), "{part}");
        let summary = ::mcap::Summary::read(&output).expect("a summary").expect("a summary");
        let channel = summary.channels.values().find(|channel| channel.topic == topic).expect("a channel");
        let schema = channel.schema.as_ref().expect("a schema");
        assert_eq!(schema.name, name);
        assert!(!schema.data.is_empty(), "{part}");
        let result = checked(&output).result;
        let wrong: Vec<_> = result.findings.groups().map(|group| (group.rule.id, &group.subject)).collect();
        assert!(!wrong.iter().any(|(_, subject)| subject.contains(topic)), "{part}: {wrong:?}");
        assert_eq!(result.corruption, Vec::new(), "{part}");
    }
}
