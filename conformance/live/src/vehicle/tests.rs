//! Tests of probes over a bus within the process.

use std::collections::BTreeMap;
use std::thread;

use uavspec_model::{ApplicationType, Findings, Qos, Reliability};
use uavspec_report::{CheckedCapture, OutcomeKind, Settings, Subject};
use uavspec_rules::definitions::EventMetadata;
use uavspec_rules::rule;
use uavspec_rules::sample::Flight;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::fingerprint::ros_name;
use uavspec_test_support::extent;

use super::*;
use crate::bus::Publisher;
use crate::bus::memory::{MemoryBus, Network};

/// The time for which these tests listen.
const TIME: Duration = Duration::from_millis(2_200);

/// The listening time of tests that need messages after the release has been chosen.
const LONG: Duration = Duration::from_secs(5);

/// Publishes the messages of a flight on the topics for which `is_flown` returns true. The topics announce their type
/// hashes.
fn fly(bus: &mut MemoryBus, flight: &Flight<'_>, is_flown: impl Fn(&str) -> bool) {
    fly_as(bus, flight, true, is_flown);
}

fn fly_as(bus: &mut MemoryBus, flight: &Flight<'_>, has_hashes: bool, is_flown: impl Fn(&str) -> bool) {
    let schema = &flight.definitions.schema;
    let publishers: Vec<_> = flight
        .topics
        .iter()
        .map(|topic| {
            let message = schema.message(topic.message);
            let topic = Topic {
                name: format!("/fmu/out/{}", topic.name).into(),
                type_name: ros_name(schema, message).into(),
                type_hash: has_hashes.then(|| message.type_hash.as_str().into()),
            };
            is_flown(&message.name).then(|| bus.advertise(&topic, &Qos::PX4).expect("a publisher"))
        })
        .collect();
    // The probe subscribes once it has discovered the publishers.
    bus.clock().sleep(Duration::from_millis(200));
    for sent in &flight.messages {
        let Some(publisher) = publishers[sent.topic] else { continue };
        let payload = flight.message(sent).expect("a message").to_cdr(ByteOrder::LittleEndian);
        bus.publish(publisher, &payload.expect("a payload")).expect("published");
    }
}

/// The numbers of findings, by rule and subject.
fn counts(findings: &Findings) -> BTreeMap<(&'static str, String), u64> {
    findings.groups().map(|group| ((group.rule.id, group.subject.clone()), group.count)).collect()
}

/// Probes a vehicle while `act` uses the network. Also checks the recording, which must have the same findings.
fn probed(time: Duration, act: impl FnOnce(&Network, &Clock) + Send) -> Checked {
    probed_with(Options::new(time), act)
}

fn probed_with(options: Options, act: impl FnOnce(&Network, &Clock) + Send) -> Checked {
    probed_by(&Library::built_in(), options, act)
}

fn probed_by(library: &Library, options: Options, act: impl FnOnce(&Network, &Clock) + Send) -> Checked {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let found = simulated(act, |bus| {
        let options = Options { record: Some(file.clone()), ..options };
        probe(bus, library, &options, &|_| {}).expect("a result")
    });
    // The recording contains the data that the user passed.
    let recorded = check_path(&file, None, &Library::built_in(), &|input| input).expect("a recording");
    let [live, later] = [&found, &recorded];
    assert_eq!(counts(&live.result.findings), counts(&later.result.findings));
    assert_eq!(live.definitions.name, later.definitions.name);
    assert_eq!(live.result.records, later.result.records);
    assert_eq!(live.result.notes, later.result.notes);
    assert_eq!(live.result.cut_short, later.result.cut_short);
    let origins = [live, later].map(|checked| checked.result.event_metadata.clone());
    let is_given = library.events().file().is_some();
    let own = "its own event metadata";
    assert!(origins[0] == origins[1] || is_given && origins[1].as_deref() == Some(own), "{origins:?}");
    assert_eq!(live.result.extent, later.result.extent);
    assert_eq!(live.result.corruption, later.result.corruption);
    let texts = |checked: &Checked| {
        let groups = checked.result.findings.groups();
        let texts = groups.flat_map(|group| group.examples.clone());
        texts.map(|(location, detail)| format!("{location}: {detail} {:?}", detail.time)).collect::<Vec<_>>()
    };
    assert_eq!(texts(live), texts(later));
    found
}

/// Runs a probe in simulated time, while `act` uses the network in another thread.
fn simulated<T>(act: impl FnOnce(&Network, &Clock) + Send, probe: impl FnOnce(&mut MemoryBus) -> T) -> T {
    let (network, clock) = (Network::default(), Clock::simulated());
    thread::scope(|scope| {
        let acting = clock.spawn(scope, |clock| act(&network, clock));
        let found = probe(&mut network.connect("/probe", &clock));
        acting.join().expect("no panic");
        found
    })
}

fn outcome(checked: Checked) -> OutcomeKind {
    let Checked { result, definitions } = checked;
    let capture = CheckedCapture::new("dds://0".to_owned(), result, Duration::ZERO);
    Subject::from_capture(capture, &definitions, &Settings::default()).outcome.kind
}

#[test]
fn a_healthy_vehicle_conforms() {
    let found = probed(TIME, |network, clock| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
        clock.sleep(TIME);
    });
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    assert!(found.result.records > 100, "{}", found.result.records);
    assert_eq!((&found.result.notes, &found.result.cut_short), (&Vec::new(), &Vec::new()));
    assert_eq!(outcome(found), OutcomeKind::Conforms);
}

#[test]
fn a_recording_contains_the_event_metadata_that_the_user_gave() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("events.json");
    std::fs::write(&file, r#"{"version": 2, "components": {}}"#).expect("a file");
    let library = Library::built_in().with_events(EventMetadata::load(&file).expect("metadata"));
    let found = probed_by(&library, Options::new(TIME), |network, clock| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
        clock.sleep(TIME);
    });
    assert_eq!(found.result.event_metadata.as_deref(), file.to_str());
}

#[test]
fn a_reliable_subscriber_of_a_best_effort_publisher_is_found() {
    let found = probed(TIME, |network, clock| {
        let definitions = Definitions::built_in();
        let mut application = network.connect("/ground_station", clock);
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
        fly(&mut network.connect("/px4", clock), &flight, |name| name == "ArmingCheckRequest");
        clock.sleep(TIME);
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
    let found = probed(LONG, |network, clock| {
        let library = Library::release("px4@1.15").expect("a release");
        let flight = Flight::new(library.base());
        let mut px4 = network.connect("/px4", clock);
        fly(&mut px4, &flight, |name| name == "ArmingCheckRequest");
        clock.sleep(START);
        fly(&mut px4, &flight, |name| name == "VehicleStatus" || name == "BatteryStatus");
    });
    assert_eq!(found.definitions.name, "PX4 1.15");
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
}

#[test]
fn names_of_topics_show_the_release_of_a_vehicle_without_type_hashes() {
    let options = Options { role: Some(Side::Component), ..Options::new(LONG) };
    let found = probed_with(options, |network, clock| {
        let library = Library::release("px4@1.15").expect("a release");
        let mut flight = Flight::new(library.base());
        // Two rounds are sufficient.
        flight.messages.truncate(extent(usize::MAX, 2 * flight.topics.len()));
        fly_as(&mut network.connect("/px4", clock), &flight, false, |_| true);
        clock.sleep(LONG);
    });
    // In newer releases, this size belongs to other messages, on topics with a version.
    assert_eq!(found.definitions.name, "PX4 1.15");
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
}

#[test]
fn several_components_answer_the_same_requests() {
    let options = Options { role: Some(Side::Component), ..Options::new(LONG) };
    let found = probed_with(options, |network, clock| {
        let end = clock.now() + LONG;
        let is_over = || clock.now() > end;
        let library = Library::built_in();
        thread::scope(|scope| {
            let serving = [Side::Autopilot, Side::Component].map(|side| {
                let (is_over, library) = (&is_over, &library);
                clock.spawn(scope, move |clock| {
                    let mut bus = network.connect(&format!("/{side:?}"), clock);
                    serve(&mut bus, library, &Namespace::default(), side, None, is_over).expect("served");
                })
            });
            for task in serving {
                task.join().expect("no panic");
            }
        });
    });
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    let covered = found.result.findings.covered(rule("PX-EXT-01").expect("a rule"));
    assert!(covered > 5, "{covered}");
}

#[test]
fn only_selected_topics_are_received() {
    let (definitions, library) = (Definitions::built_in(), Library::built_in());
    let topics = globset::GlobSetBuilder::new()
        .add(globset::Glob::new("/fmu/out/failsafe*").expect("a pattern"))
        .build()
        .expect("patterns");
    let options = Options { topics: Some(topics), ..Options::new(TIME) };
    let flying = |network: &Network, clock: &Clock| {
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
    };
    let found = simulated(flying, |bus| probe(bus, &library, &options, &|_| {}).expect("a result"));
    let flights = Flight::new(&definitions);
    assert_eq!(found.result.records, flights.counts()["failsafe_flags"]);
}

/// Compares an application that uses a release with the reference autopilot, which uses PX4 1.18.
fn compared_with(release: &str) -> Checked {
    let library = Library::release(release).expect("a release");
    let application = ApplicationType::all(&library.base().schema);
    let options = Options { application: Some(application), ..Options::new(LONG) };
    probed_with(options, |network, clock| {
        let end = clock.now() + LONG;
        let is_over = || clock.now() > end;
        let library = Library::release("px4@1.18").expect("a release");
        serve(
            &mut network.connect("/px4", clock),
            &library,
            &Namespace::default(),
            Side::Autopilot,
            None,
            &is_over,
        )
        .expect("served");
    })
}

#[test]
fn an_application_with_the_definitions_of_the_vehicle_conforms() {
    let found = compared_with("px4@1.18");
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    let rule = rule("PX-HASH-02").expect("a rule");
    assert_eq!(found.result.findings.covered(rule), 11);
    assert_eq!(found.result.notes, Vec::<String>::new());
}

/// Runs a reference participant with a release, and probes it in the opposite role.
fn probed_reference(release: &str, namespace: &str, side: Side) -> Checked {
    let role = if side == Side::Autopilot { Side::Component } else { Side::Autopilot };
    probed_with(Options { role: Some(role), ..Options::new(LONG) }, |network, clock| {
        let end = clock.now() + LONG;
        let is_over = || clock.now() > end;
        let library = Library::release(release).expect("a release");
        let namespace = namespace.parse().expect("a namespace");
        serve(&mut network.connect("/px4", clock), &library, &namespace, side, None, &is_over)
            .expect("served");
    })
}

#[test]
fn roles_speak_the_release_of_the_vehicle() {
    let releases = ["1.15", "1.16", "1.17", "1.18", "main"];
    let vehicles = releases
        .into_iter()
        .flat_map(|release| [Side::Autopilot, Side::Component].map(|side| (format!("px4@{release}"), side)));
    for (release, side) in vehicles.step_by(extent(1, 5)) {
        let found = probed_reference(&release, "", side);
        assert_eq!(counts(&found.result.findings), BTreeMap::new(), "{release} {side:?}");
        assert_eq!(found.result.notes, Vec::<String>::new(), "{release} {side:?}");
        let replies = rule("PX-EXT-01").expect("a rule");
        assert!(found.result.findings.covered(replies) > 0, "{release} {side:?}");
    }
}

#[test]
fn roles_use_the_namespace_of_the_vehicle() {
    let found = probed_reference("px4@1.17", "fleet/uav_1", Side::Autopilot);
    assert_eq!(counts(&found.result.findings), BTreeMap::new());
    assert_eq!(found.result.notes, Vec::<String>::new());
    assert!(found.result.findings.covered(rule("PX-EXT-01").expect("a rule")) > 0);
}

#[test]
fn several_vehicles_require_a_choice() {
    let found =
        probed_with(Options { role: Some(Side::Component), ..Options::new(TIME) }, |network, clock| {
            for topic in ["/a/fmu/out/wind", "/b/fmu/out/wind"] {
                network.send(&Event::Endpoint(Endpoint::publisher(topic)), usize::MAX);
            }
            clock.sleep(TIME);
        });
    let problem = "there are several vehicles: choose one with --namespace /a or /b";
    assert_eq!(found.result.cut_short, [problem]);
}

#[test]
fn vehicles_that_left_need_no_choice() {
    let found = probed_with(Options { role: Some(Side::Component), ..Options::new(TIME) }, |network, _| {
        let [gone, present] = ["/a/fmu/out/wind", "/b/fmu/out/wind"].map(Endpoint::publisher);
        let ended = Event::Ended(gone.id.clone());
        for event in [Event::Endpoint(gone), ended, Event::Endpoint(present)] {
            network.send(&event, usize::MAX);
        }
    });
    assert_eq!(found.result.cut_short, Vec::<String>::new());
}

#[test]
fn an_application_of_another_release_is_found() {
    let found = compared_with("px4@1.17");
    let groups: Vec<_> = found.result.findings.groups().collect();
    let subjects: Vec<_> = groups.iter().map(|group| (group.rule.id, &*group.subject)).collect();
    let topics = [
        "/fmu/in/register_ext_component_request",
        "/fmu/out/failsafe_flags",
        "/fmu/out/register_ext_component_reply",
        "/fmu/out/vehicle_status",
    ];
    assert_eq!(subjects, topics.map(|topic| ("PX-HASH-02", topic)), "{groups:?}");
}

#[test]
fn lost_messages_make_the_outcome_incomplete() {
    let found = probed(TIME, |network, clock| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
        network.send(&Event::Lost { topic: "/fmu/out/failsafe_flags".into(), count: 7 }, usize::MAX);
        clock.sleep(TIME);
    });
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

/// The texts about data that wasn't received, or can't be read.
fn gaps(checked: &Checked) -> Vec<&str> {
    checked.result.corruption.iter().map(|(_, text)| text.as_str()).collect()
}

#[test]
fn unreadable_messages_make_the_outcome_incomplete() {
    let found = probed(TIME, |network, clock| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
        for _ in 0..2 {
            network.send(&Event::Unreadable("/wind: invalid \u{1b}".to_owned()), usize::MAX);
        }
        clock.sleep(TIME);
    });
    assert_eq!(found.result.notes, Vec::<String>::new());
    assert_eq!(gaps(&found), ["/wind: invalid \\u{1b} (2 times)"]);
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

/// A bus that refuses all topics, and reports a loss at the end.
struct Refusing(MemoryBus);

impl Bus for Refusing {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        self.0.receive(deadline)
    }

    fn subscribe(&mut self, _: &Topic, _: &Qos) -> Result<(), String> {
        Err("refused".to_owned())
    }

    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String> {
        self.0.advertise(topic, qos)
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        self.0.publish(publisher, payload)
    }

    fn clock(&self) -> Clock {
        self.0.clock()
    }

    fn remaining_losses(&mut self) -> Vec<Event> {
        vec![Event::Lost { topic: "/wind".into(), count: 3 }]
    }
}

#[test]
fn refused_topics_and_late_losses_make_the_outcome_incomplete() {
    let (network, library) = (Network::default(), Library::built_in());
    let mut bus = Refusing(network.connect("/probe", &Clock::simulated()));
    network.send(&Event::Endpoint(Endpoint::publisher("/wind")), usize::MAX);
    let found = probe(&mut bus, &library, &Options::new(TIME), &|_| {}).expect("a result");
    let lost = "3 messages of /wind were lost before they were recorded";
    assert_eq!(gaps(&found), ["/wind: refused", lost]);
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

#[test]
fn notes_beyond_the_maximum_are_counted() {
    let found = probed(TIME, |network, _| {
        for number in 0..MAX_NOTES + 7 {
            network.send(&Event::Problem(format!("remark {number}")), usize::MAX);
        }
    });
    assert_eq!(found.result.notes.len(), MAX_NOTES + 1);
    assert_eq!(found.result.notes[MAX_NOTES], "… and 7 more notes");
}

#[test]
fn recordings_contain_problems_and_the_reason_of_an_early_end() {
    let found = probed(TIME, |network, clock| {
        let definitions = Definitions::built_in();
        fly(&mut network.connect("/px4", clock), &Flight::new(&definitions), |_| true);
        network.send(&Event::Problem("/wind: unreadable \u{1b}".to_owned()), usize::MAX);
        network.send(&Event::Problem("/wind: unreadable \u{1b}".to_owned()), usize::MAX);
        // After the release was chosen.
        clock.sleep(START);
        network.send(&Event::Problem("a second problem".to_owned()), usize::MAX);
        network.send(&Event::Closed("the server ended".to_owned()), usize::MAX);
    });
    assert_eq!(found.result.notes, ["/wind: unreadable \\u{1b}", "a second problem"]);
    assert_eq!(found.result.cut_short, ["the server ended"]);
    assert_eq!(outcome(found), OutcomeKind::Incomplete);
}

#[test]
fn topics_without_a_ros_name_are_noted() {
    let found = probed(TIME, |network, clock| {
        network.send(&Event::Endpoint(Endpoint::publisher("rq/service")), usize::MAX);
        let wind = Endpoint { is_matched_by_qos: false, ..Endpoint::publisher("wind") };
        network.send(&Event::Endpoint(wind), usize::MAX);
        clock.sleep(TIME);
    });
    assert_eq!(found.result.notes, ["wind: not checked, because the names of ROS topics start with `/`"]);
}
