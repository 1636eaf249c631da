//! Tests of the state and the playback.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use ratatui::crossterm::event::KeyCode;
use serde_json::{Value, json};
use uavspec_check::observe_capture;
use uavspec_check::timeline::Severity;
use uavspec_model::Qos;
use uavspec_model::clock::Clock;
use uavspec_rules::definitions::Library;
use uavspec_rules::sample::{Encoding, Flight, PERIOD, START};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::translation::Translations;

use super::playback::{Kind, Playback, Shown, Watcher};
use super::source::{replay, watch_live};
use super::*;
use crate::bus::memory::Network;
use crate::bus::{Bus as _, Event, Topic};
use crate::watch::fleet::Link;
use crate::watch::screen::{Pages, Step};

/// The last round in which the component replies.
const LAST_REPLY: u64 = 30;

pub(crate) fn texts() -> Texts {
    Texts::of(Translations::default())
}

pub(crate) fn library() -> Library {
    Library::release("px4@1.16").expect("a release")
}

/// The modes as a mask.
fn modes(modes: &[u32]) -> Value {
    modes.iter().map(|mode| 1_u32 << mode).sum::<u32>().into()
}

/// A vehicle in position mode (2) that can't arm: it has no position, its battery is low, one component refuses to arm,
/// and another component stops replying.
pub(crate) fn grounded(definitions: &Definitions) -> Flight<'_> {
    let mut flight = Flight::new(definitions);
    let names: Vec<&str> =
        flight.topics.iter().map(|topic| definitions.schema.message(topic.message).name.as_str()).collect();
    let topics = flight.topics.clone();
    flight.messages.retain(|sent| TOPICS.contains(&topics[sent.topic].name.as_str()));
    flight.messages.retain(|sent| {
        let round = (sent.value["timestamp"].as_u64().expect("a time") - START) / PERIOD;
        match names[sent.topic] {
            "UnregisterExtComponent" => false,
            "ArmingCheckReply" => sent.value["registration_id"] == 3 || round <= LAST_REPLY,
            _ => true,
        }
    });
    for sent in &mut flight.messages {
        change(names[sent.topic], &mut sent.value);
    }
    flight
}

/// Sets the values of a message.
fn change(message: &str, value: &mut Value) {
    let fields = match message {
        "VehicleStatus" => json!({ "nav_state": 2, "nav_state_user_intention": 2, "arming_state": 1,
            "failsafe": false, "pre_flight_checks_pass": false }),
        "BatteryStatus" => json!({ "id": 1, "connected": true, "remaining": 0.18, "voltage_v": 14.25,
            "warning": 1, "faults": 0 }),
        "RegisterExtComponentReply" if value["arming_check_id"] == 3 => {
            json!({ "name": "Precision landing", "mode_id": 23 })
        }
        "RegisterExtComponentReply" => json!({ "name": "Sprayer\u{1b}[31m", "mode_id": -1 }),
        "ArmingCheckRequest" => json!({ "valid_registrations_mask": 0b10_1000 }),
        "ArmingCheckReply" if value["registration_id"] == 3 => {
            let mut arguments = vec![0; 25];
            arguments[1] = 0xab;
            let event = json!({ "id": (1 << 24) + 77, "arguments": arguments, "log_levels": 0x64 });
            for (name, field) in event.as_object().expect("an object") {
                value["events"][0][name] = field.clone();
            }
            json!({ "can_arm_and_run": false, "num_events": 1 })
        }
        "ArmingCheckReply" => json!({ "can_arm_and_run": true, "num_events": 0 }),
        "FailsafeFlags" => {
            for (name, field) in value.as_object_mut().expect("an object") {
                if name.starts_with("mode_req_") {
                    *field = 0.into();
                } else if field.is_boolean() {
                    *field = false.into();
                }
            }
            json!({ "local_position_invalid": true, "home_position_invalid": true, "gcs_connection_lost": true,
                "battery_warning": 1, "mode_req_local_position": modes(&[2, 3, 4]),
                "mode_req_home_position": modes(&[3, 5]), "mode_req_other": modes(&[23]),
                "mode_req_prevent_arming": modes(&[18]) })
        }
        _ => json!({}),
    };
    for (name, field) in fields.as_object().expect("an object") {
        if let Some(known) = value.get_mut(name) {
            *known = field.clone();
        }
    }
}

/// Plays a flight, and passes the resulting state to `show`.
pub(crate) fn after<T>(flight: &Flight<'_>, show: impl FnOnce(&Shown<'_>) -> T) -> T {
    let playback = Playback::new(Kind::State(Duration::MAX), Clock::simulated());
    let bytes = Encoding::Mcap.write(flight).expect("an encoded flight");
    let texts = texts();
    let mut watcher = Watcher { playback: &playback, texts: &texts, clock: Clock::simulated() };
    observe_capture(&bytes[..], flight.definitions, &mut watcher).expect("a capture");
    playback.end(Ok(()));
    playback.show(show)
}

fn set(vehicle: &Vehicle) -> Vec<(&str, Severity)> {
    let groups = vehicle.flags.set(vehicle.status.mode);
    groups.concat().iter().map(|flag| (flag.known.name.as_str(), flag.severity)).collect()
}

#[test]
fn flags_that_the_mode_requires_come_first() {
    let library = library();
    after(&grounded(library.base()), |shown| {
        assert_eq!(
            set(shown.vehicle),
            [
                ("local_position_invalid", Severity::Error),
                ("home_position_invalid", Severity::Warning),
                ("gcs_connection_lost", Severity::Warning),
                ("battery_warning", Severity::Warning),
            ]
        );
        let blocked: Vec<Vec<i128>> =
            shown.vehicle.flags.blocked().into_iter().map(|(modes, _)| modes).collect();
        assert_eq!(blocked, [vec![2, 4], vec![3], vec![5], vec![23]]);
    });
}

#[test]
fn modes_that_prevent_arming_are_errors() {
    let library = library();
    let mut flight = grounded(library.base());
    let topic = flight.topic("VehicleStatus").expect("a topic");
    for sent in flight.messages.iter_mut().filter(|sent| sent.topic == topic) {
        sent.value["nav_state"] = 18.into();
    }
    after(&flight, |shown| {
        let errors = set(shown.vehicle).into_iter().filter(|(_, severity)| *severity == Severity::Error);
        assert_eq!(errors.map(|(name, _)| name).collect::<Vec<_>>(), ["mode_req_prevent_arming"]);
    });
}

#[test]
fn components_are_late_after_three_unanswered_requests() {
    let library = library();
    let flight = grounded(library.base());
    after(&flight, |shown| {
        let all = &shown.vehicle.components.all;
        let states: Vec<_> = all.iter().map(|(id, component)| (*id, component.readiness())).collect();
        assert_eq!(states, [(3, Readiness::NotReady), (5, Readiness::Late)]);
        assert_eq!(all[&3].reasons.len(), 1);
        assert!(all[&5].replied < all[&3].replied && all[&5].unanswered >= 10);
    });
}

#[test]
fn a_component_that_leaves_is_removed() {
    let definitions = Definitions::built_in();
    after(&Flight::new(&definitions), |shown| {
        assert_eq!(shown.vehicle.components.all.len(), 0);
        assert!(shown.vehicle.components.has_request && shown.vehicle.messages > 100);
        assert_eq!(shown.vehicle.unreadable, 0);
    });
}

#[test]
fn batteries_state_their_charge_and_warning() {
    let library = library();
    after(&grounded(library.base()), |shown| {
        let battery = &shown.vehicle.batteries[&1];
        assert_eq!((battery.percent, battery.tenth_volts), (Some(18), Some(143)));
        assert_eq!(battery.warning.as_ref().map(|warning| warning.severity), Some(Severity::Warning));
    });
}

#[test]
fn keys_control_the_playback() {
    let playback = Playback::new(Kind::Replay, Clock::simulated());
    let mut pages = Pages::default();
    let mut press = |key: char| {
        assert_eq!(playback.press(&mut pages, KeyCode::Char(key).into()), Step::Stay);
        playback.show(|shown| (shown.state.is_paused, shown.state.speed()))
    };
    let states: Vec<_> = " p.+-----".chars().map(&mut press).collect();
    let speeds = [1.0, 1.0, 1.0, 2.0, 1.0, 0.5, 0.25, 0.25, 0.25];
    let is_paused = [true, false, true, true, true, true, true, true, true];
    assert_eq!(states, is_paused.into_iter().zip(speeds).collect::<Vec<_>>());
    assert!(press('/').0);
    assert_eq!(press('p'), (true, 0.25), "it belongs to the filter");
}

/// Waits until a condition is met.
fn wait_until(playback: &Playback, clock: &Clock, condition: impl Fn(&Shown<'_>) -> bool) {
    let end = clock.now() + Duration::from_secs(1_000);
    let met = clock.poll(end, Duration::ZERO, || playback.show(&condition).then_some(()));
    met.expect("the condition is met");
}

#[test]
fn replays_pause_step_and_continue() {
    let definitions = Definitions::built_in();
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    let bytes = Encoding::Mcap.write(&grounded(&definitions)).expect("an encoded flight");
    file.write_all(&bytes).expect("written");
    let (clock, texts, library) = (Clock::simulated(), texts(), Library::built_in());
    let playback = Playback::new(Kind::Replay, clock.clone());
    playback.pause();
    thread::scope(|scope| {
        let replaying = clock.spawn(scope, |clock| {
            let watcher = Watcher { playback: &playback, texts: &texts, clock: clock.clone() };
            replay(file.path(), &library, watcher);
        });
        let messages = || playback.show(|shown| shown.vehicle.messages);
        clock.sleep(Duration::from_millis(300));
        assert_eq!(messages(), 0, "it is paused");
        playback.step();
        wait_until(&playback, &clock, |shown| shown.vehicle.has_state());
        clock.sleep(Duration::from_millis(100));
        let first = messages();
        playback.step();
        wait_until(&playback, &clock, |shown| shown.vehicle.messages > first);
        assert!(playback.show(|shown| shown.state.is_paused && shown.state.end.is_none()));
        playback.pause();
        playback.accelerate(1);
        wait_until(&playback, &clock, |shown| shown.state.end.is_some());
        assert_eq!(playback.wait_for_start(), Ok(()));
        replaying.join().expect("no panic");
    });
}

#[test]
fn replays_report_files_that_are_no_captures() {
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    file.write_all(b"glider").expect("written");
    let (clock, texts) = (Clock::simulated(), texts());
    let playback = Playback::new(Kind::Replay, clock.clone());
    replay(file.path(), &Library::built_in(), Watcher { playback: &playback, texts: &texts, clock });
    let problem = playback.wait_for_start().expect_err("a problem");
    assert!(problem.starts_with("unknown file type"), "{problem}");
}

/// Set to true to end the live display.
static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Ends the live display when this value is dropped, even if the test fails.
struct Stop;

impl Drop for Stop {
    fn drop(&mut self) {
        IS_STOPPED.store(true, Ordering::Relaxed);
    }
}

#[test]
fn live_vehicles_are_shown_and_reconnected() {
    let definitions = Definitions::built_in();
    let flight = grounded(&definitions);
    let (clock, texts, library) = (Clock::simulated(), texts(), Library::built_in());
    let playback = Playback::new(Kind::Live, clock.clone());
    let network = Network::default();
    let mut px4 = network.connect("/px4", &clock);
    let publishers: Vec<_> = flight
        .topics
        .iter()
        .map(|topic| {
            let message = definitions.schema.message(topic.message);
            let topic = Topic {
                name: format!("/fmu/out/{}", topic.name).into(),
                type_name: ros_name(&definitions.schema, message).into(),
                type_hash: Some(message.type_hash.as_str().into()),
            };
            px4.advertise(&topic, &Qos::PX4).expect("a publisher")
        })
        .collect();
    let mut fly = |count: usize| {
        for sent in flight.messages.iter().take(count) {
            let payload = flight.message(sent).expect("a message").to_cdr(ByteOrder::LittleEndian);
            px4.publish(publishers[sent.topic], &payload.expect("a payload")).expect("published");
        }
    };
    thread::scope(|scope| {
        let stop = Stop;
        let watching = clock.spawn(scope, |clock| {
            let connect = || Ok(Box::new(network.connect("/watch", clock)) as Box<dyn crate::bus::Bus>);
            let is_stopped = || IS_STOPPED.load(Ordering::Relaxed);
            let watcher = Watcher { playback: &playback, texts: &texts, clock: clock.clone() };
            watch_live(&connect, is_stopped, &library, watcher);
        });
        playback.wait_for_start().expect("a connection");
        clock.sleep(Duration::from_millis(500));
        fly(usize::MAX);
        wait_until(&playback, &clock, |shown| shown.vehicle.components.all.len() == 2);
        playback.show(|shown| {
            assert_eq!(set(shown.vehicle).len(), 4);
            let refused = shown.vehicle.refused.as_deref().expect("a report");
            let reasons = refused.iter().flat_map(|refused| refused.reasons.iter().chain(&refused.general));
            let names: BTreeSet<&str> = reasons.map(|reason| reason.name.as_str()).collect();
            assert_eq!(names, BTreeSet::from(["px4::check_modes_global_pos"]));
            assert!(age(shown.vehicle.latest.expect("a message"), shown.now) < Duration::from_secs(60));
        });
        network.send(&Event::Lost { topic: "/fmu/out/failsafe_flags".into(), count: 7 }, usize::MAX);
        network.send(&Event::Problem("a broken datagram".to_owned()), usize::MAX);
        wait_until(&playback, &clock, |shown| shown.state.lost == 7 && shown.state.notes.len() == 1);
        playback.pause();
        let messages = playback.show(|shown| shown.vehicle.messages);
        fly(20);
        wait_until(&playback, &clock, |shown| !shown.state.waiting.is_empty());
        assert_eq!(playback.show(|shown| shown.vehicle.messages), messages, "the display is paused");
        playback.step();
        assert!(playback.show(|shown| shown.vehicle.messages) > messages);
        playback.pause();
        network.send(&Event::Closed("the vehicle left".to_owned()), usize::MAX);
        wait_until(
            &playback,
            &clock,
            |shown| matches!(&shown.state.link, Link::Lost { reason, .. } if reason == "the vehicle left"),
        );
        wait_until(&playback, &clock, |shown| shown.state.link == Link::Connected);
        drop(stop);
        watching.join().expect("no panic");
    });
}

#[test]
fn the_first_connection_must_succeed() {
    let clock = Clock::simulated();
    let playback = Playback::new(Kind::Live, clock.clone());
    let watcher = Watcher { playback: &playback, texts: &texts(), clock };
    watch_live(&|| Err("nobody listens".to_owned()), || false, &Library::built_in(), watcher);
    assert_eq!(playback.wait_for_start(), Err("nobody listens".to_owned()));
}
