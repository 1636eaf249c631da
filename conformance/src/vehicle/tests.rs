//! Tests of probes over a bus within the process.

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;

use uavspec_codegen::schema::fingerprint::ros_name;
use uavspec_runtime::cdr::ByteOrder;

use super::*;
use crate::bus::memory::{MemoryBus, Network};
use crate::model::{ApplicationType, Findings, Qos, Reliability};
use crate::report::{CheckedCapture, OutcomeKind, Settings, Subject};
use crate::rules::rule;
use crate::rules::sample::Flight;

/// The time for which these tests listen.
const TIME: Duration = Duration::from_millis(2_200);

/// The time for messages after the release was chosen, even on a slow machine.
const LONG: Duration = Duration::from_secs(5);

/// Publishes the messages of a flight on these topics.
fn fly(bus: &mut MemoryBus, flight: &Flight<'_>, is_flown: impl Fn(&str) -> bool) {
    let schema = &flight.definitions.schema;
    let publishers: Vec<_> = flight
        .topics
        .iter()
        .map(|topic| {
            let message = schema.message(topic.message);
            let topic = Topic {
                name: format!("/fmu/out/{}", topic.name).into(),
                type_name: ros_name(schema, message).into(),
                type_hash: Some(message.type_hash.as_str().into()),
            };
            is_flown(&message.name).then(|| bus.advertise(&topic, &Qos::PX4).expect("a publisher"))
        })
        .collect();
    // The probe subscribes when it has discovered the publishers.
    thread::sleep(Duration::from_millis(200));
    for sent in &flight.messages {
        let Some(publisher) = publishers[sent.topic] else { continue };
        let payload = flight.message(sent).expect("a message").to_cdr(ByteOrder::LittleEndian);
        bus.publish(publisher, &payload.expect("a payload")).expect("published");
    }
}

fn options(time: Duration, record: Option<&Path>) -> Options {
    let record = record.map(Path::to_path_buf);
    Options { time, topics: None, role: None, application: None, record, is_stopped: Box::new(|| false) }
}

/// The numbers of findings, by rule and subject.
fn counts(findings: &Findings) -> BTreeMap<(&'static str, String), u64> {
    findings.groups().map(|group| ((group.rule.id, group.subject.clone()), group.count)).collect()
}

/// Probes while `act` uses the network. Also checks the recording, which must have the same findings.
fn probed(time: Duration, act: impl FnOnce(&Network) + Send) -> Checked {
    probed_with(options(time, None), act)
}

fn probed_with(options: Options, act: impl FnOnce(&Network) + Send) -> Checked {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let (network, library) = (Network::default(), Library::built_in());
    let mut bus = network.connect("/probe");
    let found = thread::scope(|scope| {
        scope.spawn(|| act(&network));
        let options = Options { record: Some(file.clone()), ..options };
        probe(&mut bus, &library, &options, &|_| {}).expect("a result")
    });
    let recorded = check_path(&file, None, &library, &|input| input).expect("a recording");
    let [live, later] = [&found, &recorded];
    assert_eq!(counts(&live.result.findings), counts(&later.result.findings));
    assert_eq!(live.definitions.name, later.definitions.name);
    assert_eq!(live.result.records, later.result.records);
    assert_eq!(live.result.notes, later.result.notes);
    assert_eq!(live.result.cut_short, later.result.cut_short);
    let texts = |checked: &Checked| {
        let groups = checked.result.findings.groups();
        let texts = groups.flat_map(|group| group.examples.clone());
        texts.map(|(location, detail)| format!("{location}: {detail} {:?}", detail.time)).collect::<Vec<_>>()
    };
    assert_eq!(texts(live), texts(later));
    found
}

fn outcome(checked: Checked) -> OutcomeKind {
    let Checked { result, definitions } = checked;
    let capture = CheckedCapture {
        path: "dds://0".to_owned(),
        result,
        notes: Vec::new(),
        requests: Vec::new(),
        cut_short: Vec::new(),
        elapsed: 1,
    };
    Subject::from_capture(capture, &definitions, &Settings::default()).outcome.kind
}

#[test]
fn a_healthy_vehicle_conforms() {
    let found = probed(TIME, |network| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4"), &Flight::new(&definitions), |_| true);
        thread::sleep(TIME);
    });
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    assert!(found.result.records > 100, "{}", found.result.records);
    assert_eq!((&found.result.notes, &found.result.cut_short), (&Vec::new(), &Vec::new()));
    assert_eq!(outcome(found), OutcomeKind::Conforms);
}

#[test]
fn a_reliable_subscriber_of_a_best_effort_publisher_is_found() {
    let found = probed(TIME, |network| {
        let definitions = Definitions::built_in();
        let mut application = network.connect("/ground_station");
        let topic = Topic {
            name: "/fmu/out/arming_check_request_v1".into(),
            type_name: "px4_msgs/msg/ArmingCheckRequest".into(),
            type_hash: None,
        };
        let qos = Qos { reliability: Reliability::Reliable, ..Qos::PX4 };
        application.subscribe(&topic, &qos).expect("a subscriber");
        let flight = Flight::new(&definitions);
        let mut flight = flight.clone();
        for topic in &mut flight.topics {
            if topic.name == "arming_check_request" {
                topic.name += "_v1";
            }
        }
        fly(&mut network.connect("/px4"), &flight, |name| name == "ArmingCheckRequest");
        thread::sleep(TIME);
    });
    let groups: Vec<_> = found.result.findings.groups().collect();
    assert_eq!(groups.len(), 1, "{groups:?}");
    assert_eq!((groups[0].rule.id, groups[0].count), ("PX-QOS-01", 1));
    let (_, detail) = &groups[0].examples[0];
    assert_eq!(
        detail.message,
        "subscriber `/ground_station` requests reliability reliable, but publisher `/px4` offers best effort: \
         the subscriber receives nothing"
    );
}

#[test]
fn topics_that_appear_late_choose_the_release_again() {
    let found = probed(LONG, |network| {
        let library = Library::release("px4@1.15").expect("a release");
        let flight = Flight::new(library.base());
        let mut px4 = network.connect("/px4");
        fly(&mut px4, &flight, |name| name == "ArmingCheckRequest");
        thread::sleep(START);
        fly(&mut px4, &flight, |name| name == "VehicleStatus" || name == "BatteryStatus");
    });
    assert_eq!(found.definitions.name, "PX4 1.15");
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
}

#[test]
fn only_selected_topics_are_received() {
    let network = Network::default();
    let mut bus = network.connect("/probe");
    let definitions = Definitions::built_in();
    let library = Library::built_in();
    let topics = globset::GlobSetBuilder::new()
        .add(globset::Glob::new("/fmu/out/failsafe*").expect("a pattern"))
        .build()
        .expect("patterns");
    let found = thread::scope(|scope| {
        scope.spawn(|| fly(&mut network.connect("/px4"), &Flight::new(&definitions), |_| true));
        probe(&mut bus, &library, &Options { topics: Some(topics), ..options(TIME, None) }, &|_| {})
            .expect("a result")
    });
    let flights = Flight::new(&definitions);
    assert_eq!(found.result.records, flights.counts()["failsafe_flags"]);
}

/// Compares an application with the reference autopilot.
fn compared_with(definitions: &Definitions) -> Checked {
    let application = ApplicationType::all(&definitions.schema);
    let options = Options { application: Some(application), ..options(TIME, None) };
    probed_with(options, |network| {
        let end = Instant::now() + TIME;
        let is_over = || Instant::now() > end;
        serve(&mut network.connect("/px4"), Side::Autopilot, true, None, &is_over).expect("served");
    })
}

#[test]
fn an_application_with_the_definitions_of_the_vehicle_conforms() {
    let found = compared_with(&Definitions::built_in());
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    let rule = rule("PX-HASH-02").expect("a rule");
    assert_eq!(found.result.findings.covered(rule), 10);
    assert_eq!(found.result.notes, Vec::<String>::new());
}

#[test]
fn an_application_of_another_release_is_found() {
    let found = compared_with(Library::release("px4@1.14").expect("a release").base());
    let groups: Vec<_> = found.result.findings.groups().collect();
    assert_eq!(groups.len(), 1, "{groups:?}");
    assert_eq!((groups[0].rule.id, &*groups[0].subject), ("PX-HASH-02", "/fmu/out/failsafe_flags"));
    let (_, detail) = &groups[0].examples[0];
    assert_eq!(
        detail.message,
        "FailsafeFlags: the application has that of px4@1.14, but the vehicle has that of px4@1.15: missing fields: \
         geofence_breached (bool); additional fields: primary_geofence_breached (bool). All other values are at the \
         same positions"
    );
}

#[test]
fn lost_messages_make_the_outcome_incomplete() {
    let found = probed(TIME, |network| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4"), &Flight::new(&definitions), |_| true);
        network.send(&Event::Lost { topic: "/fmu/out/failsafe_flags".into(), count: 7 }, usize::MAX);
        thread::sleep(TIME);
    });
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

#[test]
fn recordings_contain_problems_and_the_reason_of_an_early_end() {
    let found = probed(TIME, |network| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4"), &Flight::new(&definitions), |_| true);
        network.send(&Event::Problem("/wind: unreadable \u{1b}".to_owned()), usize::MAX);
        network.send(&Event::Problem("/wind: unreadable \u{1b}".to_owned()), usize::MAX);
        // After the release was chosen.
        thread::sleep(START);
        network.send(&Event::Problem("a second problem".to_owned()), usize::MAX);
        network.send(&Event::Closed("the server ended".to_owned()), usize::MAX);
    });
    assert_eq!(found.result.notes, ["/wind: unreadable \\u{1b}", "a second problem"]);
    assert_eq!(found.result.cut_short, ["the server ended"]);
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

#[test]
fn topics_without_a_ros_name_are_noted() {
    let found = probed(TIME, |network| {
        let endpoint = |name: &str, is_matched_by_qos| Endpoint {
            id: name.to_owned(),
            kind: EndpointKind::Publisher,
            node: None,
            topic: name.to_owned(),
            type_name: "T".to_owned(),
            type_hash: None,
            qos: None,
            is_matched_by_qos,
        };
        network.send(&Event::Endpoint(endpoint("rq/service", true)), usize::MAX);
        network.send(&Event::Endpoint(endpoint("wind", false)), usize::MAX);
        thread::sleep(TIME);
    });
    assert_eq!(found.result.notes, ["wind: not checked, because the names of ROS topics start with `/`"]);
}
