//! A flight with a story: the vehicle can't arm before GPS has a fix, flies, returns because its battery is low, and
//! lands. The same flight is a log, a bag and the session of a Flockwave client, each with one violation.

use serde_json::{Value, json};
use uavspec_model::Reliability;
use uavspec_schema::{Failure, MessageId};
use uavspec_types::px4_events::px4::{
    ArmDisarmReason, CheckEstimatorGpsFixTooLow, CheckModesLocalPos, CommanderArmedBy,
    CommanderArmingCheckSummary, CommanderDisarmedBy, CommanderFailsafeEnterLowBat, CommanderHealthSummary,
    CommanderLandingDetected, CommanderTakeoffDetected, HealthComponent, NavigationModeGroup,
};

use super::log::Entry;
use super::{Flight, START, Sent, Topic, events};
use crate::definitions::Library;
use crate::flockwave::sample::Session;

/// The release of the vehicle's messages and events.
const RELEASE: &str = "px4@1.15";

/// The value of `ver_sw_release` in a log: the final release of version 1.15.0.
const VERSION: u32 = 0x010f_00ff;

/// The type of each topic, and the time between two messages, in seconds. Events have no period.
const TOPICS: [(&str, Option<f64>); 6] = [
    ("VehicleStatus", Some(0.2)),
    ("FailsafeFlags", Some(0.2)),
    ("BatteryStatus", Some(0.5)),
    ("VehicleLocalPosition", Some(0.1)),
    ("VehicleLandDetected", Some(0.5)),
    ("Event", None),
];

/// The moments of the flight, in seconds.
const BOOT: f64 = 1.0;
const FIX: f64 = 9.0;
const ARMED: f64 = 12.0;
const TAKEOFF: f64 = 14.0;
const LOW_BATTERY: f64 = 36.0;
const LANDED: f64 = 52.0;
const DISARMED: f64 = 54.0;
const END: f64 = 58.0;

/// The time at which a message is wrong, in seconds.
const SLIP: f64 = 45.0;

/// The altitude of the flight, in m, and the vertical speed, in m/s.
const ALTITUDE: f64 = 20.0;
const SPEED: f64 = 2.0;

const POSITION: u64 = 2;
const RETURN: u64 = 5;

/// The modes that don't require a position: Manual, Altitude, Acro and Stabilized.
const WITHOUT_POSITION: u32 = 1 | 1 << 1 | 1 << 10 | 1 << 15;

/// The bit of GPS in [`HealthComponent`].
const GPS: u8 = 3;

/// The state of the vehicle at a time.
struct State {
    seconds: f64,
}

impl State {
    fn has_position(&self) -> bool {
        self.seconds >= FIX
    }

    fn is_armed(&self) -> bool {
        (ARMED..DISARMED).contains(&self.seconds)
    }

    fn is_landed(&self) -> bool {
        !(TAKEOFF..LANDED).contains(&self.seconds)
    }

    fn is_returning(&self) -> bool {
        self.is_armed() && self.seconds >= LOW_BATTERY
    }

    /// The altitude above the ground, in m.
    fn altitude(&self) -> f64 {
        let [climbed, left] = [self.seconds - TAKEOFF, LANDED - self.seconds].map(|time| time * SPEED);
        climbed.min(left).clamp(0.0, ALTITUDE)
    }

    /// The charge of the battery, from 0 to 1.
    fn charge(&self) -> f64 {
        0.36 - 0.006 * self.seconds
    }

    /// The fields of a message that aren't zero.
    fn fields(&self, message: &str) -> Value {
        let since = |time: f64| if self.seconds >= time { micros(time) } else { 0 };
        match message {
            "VehicleStatus" => json!({
                "armed_time": since(ARMED),
                "takeoff_time": since(TAKEOFF),
                "arming_state": if self.is_armed() { 2 } else { 1 },
                "latest_arming_reason": if self.seconds >= ARMED { ArmDisarmReason::RC_STICK.0 } else { 0 },
                "latest_disarming_reason":
                    if self.seconds >= DISARMED { ArmDisarmReason::AUTO_DISARM_LAND.0 } else { 0 },
                "nav_state_user_intention": POSITION,
                "nav_state": if self.is_returning() { RETURN } else { POSITION },
                "vehicle_type": 1,
                "system_type": 2,
                "system_id": 1,
                "component_id": 1,
                "failsafe": self.is_returning(),
                "pre_flight_checks_pass": self.has_position(),
            }),
            "FailsafeFlags" => json!({
                "mode_req_local_position": !WITHOUT_POSITION & 0x003e_403c,
                "mode_req_global_position": 1 << RETURN | 1 << 3 | 1 << 4,
                "mode_req_home_position": 1 << RETURN,
                "mode_req_mission": 1 << 3,
                "mode_req_offboard_signal": 1 << 14,
                "local_position_invalid": !self.has_position(),
                "local_velocity_invalid": !self.has_position(),
                "global_position_invalid": !self.has_position(),
                "home_position_invalid": !self.has_position(),
                "auto_mission_missing": true,
                "offboard_control_signal_lost": true,
                "battery_warning": u8::from(self.seconds >= LOW_BATTERY),
            }),
            "BatteryStatus" => json!({
                "connected": true,
                "voltage_v": 14.0 + 2.8 * self.charge(),
                "voltage_filtered_v": 14.0 + 2.8 * self.charge(),
                "current_a": if self.is_landed() { 0.6 } else { 17.5 },
                "current_filtered_a": if self.is_landed() { 0.6 } else { 17.5 },
                "current_average_a": 12.0,
                "discharged_mah": 5000.0 * (1.0 - self.charge()),
                "remaining": self.charge(),
                "scale": 1.0,
                "time_remaining_s": 60.0 * self.charge(),
                "temperature": 31.0,
                "cell_count": 4,
                "capacity": 5000,
                "id": 1,
                "is_required": true,
                "warning": u8::from(self.seconds >= LOW_BATTERY),
            }),
            "VehicleLocalPosition" => json!({
                "timestamp_sample": micros(self.seconds),
                "xy_valid": self.has_position(),
                "z_valid": true,
                "v_xy_valid": self.has_position(),
                "v_z_valid": true,
                "z": -self.altitude(),
                "heading": 1.2,
                "xy_global": self.has_position(),
                "z_global": self.has_position(),
                "ref_lat": 47.3977,
                "ref_lon": 8.5456,
                "ref_alt": 488.0,
                "eph": if self.has_position() { 0.8 } else { 50.0 },
                "epv": 1.1,
            }),
            "VehicleLandDetected" => json!({
                "ground_contact": self.is_landed(),
                "maybe_landed": self.is_landed(),
                "landed": self.is_landed(),
                "at_rest": self.is_landed(),
            }),
            _ => json!({}),
        }
    }
}

/// A time since boot, in µs.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the times are short
fn micros(seconds: f64) -> u64 {
    START + (seconds * 1e6) as u64
}

// Levels of events.
const ERROR: u8 = 3;
const WARNING: u8 = 4;
const INFO: u8 = 6;
const PROTOCOL: u8 = 8;

/// A report about health and arming: without GPS, the vehicle can't arm in modes that require a position.
fn report(has_fix: bool) -> Vec<(u8, [Value; 2])> {
    let (none, gps) = (HealthComponent(0), HealthComponent::GPS);
    let able = if has_fix { u32::MAX } else { WITHOUT_POSITION };
    let (able, unable) = (NavigationModeGroup(able), NavigationModeGroup(!able));
    let error = if has_fix { none } else { gps };
    let summary =
        CommanderArmingCheckSummary { chunk_idx: 0, error, warning: none, can_arm: able, can_run: able };
    let mut report = vec![(PROTOCOL, events::of(&summary))];
    if !has_fix {
        let position = CheckModesLocalPos { modes: unable, health_component_index: 0 };
        let fix = CheckEstimatorGpsFixTooLow { modes: unable, health_component_index: GPS };
        report.extend([(ERROR, events::of(&position)), (ERROR, events::of(&fix))]);
    }
    let health = CommanderHealthSummary { chunk_idx: 0, is_present: gps, error, warning: none };
    report.push((PROTOCOL, events::of(&health)));
    report
}

/// The times of all events, in seconds, with the fields of the messages.
fn told() -> Vec<(f64, Value)> {
    let (by_stick, by_landing) = (ArmDisarmReason::RC_STICK, ArmDisarmReason::AUTO_DISARM_LAND);
    let told = [
        (BOOT, report(false)),
        (FIX, report(true)),
        (ARMED, vec![(INFO, events::of(&CommanderArmedBy { arg0: by_stick }))]),
        (TAKEOFF, vec![(INFO, events::of(&CommanderTakeoffDetected {}))]),
        (LOW_BATTERY, vec![(WARNING, events::of(&CommanderFailsafeEnterLowBat {}))]),
        (LANDED, vec![(INFO, events::of(&CommanderLandingDetected {}))]),
        (DISARMED, vec![(INFO, events::of(&CommanderDisarmedBy { arg0: by_landing }))]),
    ];
    let told = told.into_iter().flat_map(|(time, events)| events.into_iter().map(move |event| (time, event)));
    let fields = |(sequence, (time, (level, [id, arguments]))): (u64, (f64, (u8, [Value; 2])))| {
        // The level in logs, and the level for ground stations.
        let levels = level << 4 | level;
        (time, json!({ "id": id, "arguments": arguments, "event_sequence": sequence, "log_levels": levels }))
    };
    (0..).zip(told).map(fields).collect()
}

/// A file of the flight.
#[derive(Debug)]
pub struct File {
    /// The name.
    pub name: &'static str,
    /// The kind of the file.
    pub about: &'static str,
    /// The content.
    pub content: Vec<u8>,
}

/// The log, the bag and the session.
///
/// # Errors
/// Fails if the definitions of the release can't be read.
pub fn files() -> Result<[File; 3], Failure> {
    let library = Library::release(RELEASE)?;
    let flight = flight(&library);
    let session_about = "the messages between a Flockwave client and server";
    Ok([
        File { name: "flight.ulg", about: "a PX4 log", content: log(&flight) },
        File { name: "flight.mcap", about: "a ROS 2 bag", content: bag(&flight) },
        File { name: "session.jsonl", about: session_about, content: session().to_bytes() },
    ])
}

/// All messages of the flight, without violations.
fn flight(library: &Library) -> Flight<'_> {
    let definitions = library.base();
    let schema = &definitions.schema;
    let mut flight = Flight { definitions, topics: Vec::new(), messages: Vec::new() };
    for (name, period) in TOPICS {
        let found = (0..).map(MessageId).zip(&schema.messages).find(|(_, message)| message.name == name);
        let Some((id, topic)) = found.and_then(|(id, message)| Some((id, message.topics.first()?))) else {
            continue;
        };
        let index = flight.topics.len();
        flight.topics.push(Topic { name: topic.clone(), message: id });
        let empty = flight.type_of(index).default().to_json().unwrap_or_default();
        let sent = |seconds: f64, fields: Value| {
            let mut value = empty.clone();
            for (field, known) in fields.as_object().into_iter().flatten() {
                value[field] = known.clone();
            }
            value["timestamp"] = micros(seconds).into();
            Sent { topic: index, value }
        };
        match period {
            Some(period) => {
                let times = (0..).map(|number| f64::from(number) * period).take_while(|time| *time < END);
                flight.messages.extend(times.map(|seconds| sent(seconds, State { seconds }.fields(name))));
            }
            None => flight.messages.extend(told().into_iter().map(|(seconds, fields)| sent(seconds, fields))),
        }
    }
    flight.messages.sort_by_key(|sent| sent.value["timestamp"].as_u64());
    flight
}

/// The log. A message of the battery has an old timestamp.
fn log(flight: &Flight<'_>) -> Vec<u8> {
    let mut flight = flight.clone();
    let battery = flight.topic("BatteryStatus");
    let slips = |sent: &&mut Sent| {
        Some(sent.topic) == battery && sent.value["timestamp"].as_u64() >= Some(micros(SLIP))
    };
    if let Some(sent) = flight.messages.iter_mut().find(slips) {
        sent.value["timestamp"] = micros(SLIP - 3.0).into();
    }
    let mut log = flight.log();
    log.entries.insert(1, Entry::Information("uint32_t ver_sw_release", VERSION.to_le_bytes().to_vec()));
    log.to_bytes()
}

/// The bag. A subscriber requests reliable messages, which PX4 doesn't offer.
fn bag(flight: &Flight<'_>) -> Vec<u8> {
    let mut bag = flight.bag();
    bag.application.clear();
    let subscriber = bag
        .endpoints
        .iter_mut()
        .find(|endpoint| endpoint.id.starts_with("subscriber") && endpoint.topic.ends_with("local_position"));
    if let Some(qos) = subscriber.and_then(|endpoint| endpoint.qos.as_mut()) {
        qos.reliability = Reliability::Reliable;
    }
    bag.to_bytes()
}

/// The session of a client that follows the vehicle. In one report, the id lacks its leading zero.
fn session() -> Session {
    let mut session = Session::opened();
    let version = json!({ "software": "uavspec", "version": env!("CARGO_PKG_VERSION") });
    session.exchange(json!({ "type": "SYS-VER" }), version);
    session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["01"] }));
    let takeoff = json!({ "type": "UAV-TAKEOFF", "ids": ["01"] });
    let refused = json!({ "error": { "01": "GPS has no fix" } });
    let (mut is_refused, mut has_started) = (false, false);
    for second in (0..).step_by(2).map(f64::from).take_while(|second| *second < END) {
        let state = State { seconds: second };
        if !is_refused && second > BOOT {
            session.exchange(takeoff.clone(), refused.clone());
            is_refused = true;
        }
        if !has_started && second >= ARMED {
            session.exchange(takeoff.clone(), json!({ "result": { "01": true } }));
            has_started = true;
        }
        session.notify(json!({ "type": "UAV-INF", "status": { "01": status(&state, session.now()) } }));
        session.wait(2.0);
    }
    session.closed("client");
    session
}

/// The status of the vehicle in a report of a Flockwave server.
fn status(state: &State, now: u64) -> Value {
    let errors = [(!state.has_position(), 133), (state.seconds >= LOW_BATTERY && !state.is_landed(), 134)];
    let errors: Vec<u64> = errors.into_iter().filter(|(is_set, _)| *is_set).map(|(_, code)| code).collect();
    #[allow(clippy::cast_possible_truncation)] // the values are small
    let [altitude, charge] =
        [state.altitude() * 1e3, state.charge() * 100.0].map(|value| value.round() as i64);
    let is_wrong = (SLIP..SLIP + 2.0).contains(&state.seconds);
    json!({
        "id": if is_wrong { "1" } else { "01" },
        "timestamp": now,
        "mode": if state.is_returning() { "rth" } else { "loiter" },
        "position": [473_977_000, 85_456_000, altitude + 488_000, altitude],
        "gps": if state.has_position() { [3, 14] } else { [0, 0] },
        "heading": 687,
        "battery": [155, charge],
        "errors": errors,
    })
}
