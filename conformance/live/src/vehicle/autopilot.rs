//! The flight controller's part in arming checks, as PX4 implements it.

use std::sync::Arc;

use serde_json::{Value, json};
use uavspec_rules::px4::Sent;
use uavspec_runtime::Message as _;
use uavspec_runtime::event::Event as _;
use uavspec_types::px4::battery_status::BatteryWarning;
use uavspec_types::px4::{
    ArmingCheckReply, ArmingCheckRequest, BatteryStatus, Event, FailsafeFlags, MessageFormatRequest,
    MessageFormatResponse, RegisterExtComponentReply, RegisterExtComponentRequest, UnregisterExtComponent,
};

use super::release::Release;
use uavspec_types::px4_events::px4::{
    CommanderArmingCheckSummary, CommanderHealthSummary, HealthComponent, NavigationModeGroup,
};

use super::role::{Purpose, Role};

/// The maximum number of registrations.
const REGISTRATIONS: usize = 8;

/// The interval between requests, in µs.
const INTERVAL: u64 = 300_000;

/// The time between two requests in quick succession, in µs. A component has 50 ms to reply.
const SHORT_INTERVAL: u64 = 100_000;

/// The time from the first registration to the first request, in µs.
const FIRST_REQUEST: u64 = 100_000;

/// A component is unresponsive after this many consecutive requests without a reply.
const MAX_MISSING: u8 = 3;

/// The id of the first request. The ids wrap around after a few requests.
const FIRST_ID: u8 = 250;

/// The number of requests after which the sequence of trials starts again.
const CYCLE: u64 = 24;

/// The number of the request in a cycle that is quickly followed by another request.
const HURRIED: u64 = 4;

/// The number of the request in a cycle after which an id is skipped, as if a request had been lost.
const SKIPPED: u64 = 9;

/// The numbers of the requests in a cycle whose mask contains no registration, as if all components were unresponsive.
/// They come last, because a component may leave.
const REVOKED: std::ops::Range<u64> = 18..20;

/// The interval between vehicle states, in µs.
const STATE_INTERVAL: u64 = 500_000;

/// The id of the first external mode: `NAVIGATION_STATE_EXTERNAL1` of `VehicleStatus`.
const FIRST_MODE: i8 = 23;

/// The id of the first external mode executor. 0 is the flight controller itself.
const FIRST_EXECUTOR: i8 = 1;

/// A value that isn't a valid id.
const INVALID: i8 = -1;

/// The log levels of the summaries in a report. Users never see them.
const PROTOCOL: u8 = 0x88;

/// `ARMING_STATE_DISARMED` of `VehicleStatus`.
const DISARMED: u8 = 1;

/// `NAVIGATION_STATE_AUTO_LOITER` of `VehicleStatus`.
const HOLD: u8 = 4;

/// The mask of the valid modes.
const VALID_MODES: u32 = (1 << 5) - 1;

/// `VEHICLE_TYPE_ROTARY_WING` of `VehicleStatus`.
const ROTARY_WING: u8 = 1;

/// `MAV_TYPE_QUADROTOR` of `MAVLink`.
const QUADROTOR: u8 = 2;

/// All modes.
const ALL_MODES: u32 = u32::MAX;

const RECEIVED: &[&str] = &[
    RegisterExtComponentRequest::NAME,
    UnregisterExtComponent::NAME,
    ArmingCheckReply::NAME,
    MessageFormatRequest::NAME,
];

const JUDGE: &[&str] =
    &[ArmingCheckRequest::NAME, RegisterExtComponentReply::NAME, MessageFormatResponse::NAME];

const REFERENCE: &[&str] = &[
    ArmingCheckRequest::NAME,
    RegisterExtComponentReply::NAME,
    MessageFormatResponse::NAME,
    Event::NAME,
    FailsafeFlags::NAME,
    BatteryStatus::NAME,
    VEHICLE_STATUS,
];

/// The message type of the vehicle's state. The fields differ between releases, so there is no Rust type.
const VEHICLE_STATUS: &str = "VehicleStatus";

/// A flight controller. It never arms.
pub(super) struct Autopilot {
    purpose: Purpose,
    registrations: [Option<Registration>; REGISTRATIONS],
    /// The id of the next request.
    id: u8,
    /// The number of requests.
    count: u64,
    next_request: Option<u64>,
    next_state: Option<u64>,
    /// The number of published events.
    events: u16,
    replies: u64,
    release: Arc<Release>,
}

/// A registered component.
struct Registration {
    reply: RegisterExtComponentReply,
    /// True if the component answered the latest request.
    has_replied: bool,
    /// The number of consecutive requests without a reply.
    missing: u8,
}

impl Autopilot {
    pub(super) fn new(purpose: Purpose, now: u64, release: Arc<Release>) -> Self {
        Self {
            purpose,
            registrations: Default::default(),
            id: FIRST_ID,
            count: 0,
            next_request: None,
            next_state: (purpose != Purpose::Judge).then_some(now),
            events: 0,
            replies: 0,
            release,
        }
    }

    fn register(&mut self, request: &RegisterExtComponentRequest, now: u64) -> Vec<Sent> {
        let mut reply = RegisterExtComponentReply {
            timestamp: now,
            request_id: request.request_id,
            name: request.name,
            px4_ros2_api_version: RegisterExtComponentRequest::LATEST_PX4_ROS2_API_VERSION,
            success: false,
            arming_check_id: INVALID,
            mode_id: INVALID,
            mode_executor_id: INVALID,
        };
        if let Some(slot) = self.slot(request) {
            let id = |is_requested: bool, first: i8| if is_requested { first + slot } else { INVALID };
            reply.success = true;
            reply.arming_check_id = slot;
            reply.mode_id = id(request.register_mode, FIRST_MODE);
            reply.mode_executor_id = id(request.register_mode_executor, FIRST_EXECUTOR);
            let registration = Registration { reply: reply.clone(), has_replied: true, missing: 0 };
            self.registrations[slot.unsigned_abs() as usize] = Some(registration);
            self.next_request.get_or_insert(now + FIRST_REQUEST);
        }
        let report = if reply.success { self.report(&[], now) } else { Vec::new() };
        [Sent::new(&reply)].into_iter().chain(report).collect()
    }

    /// Answers a component that asks for the flight controller's definition of a message, to compare it with its own.
    fn answer_format(&self, request: &MessageFormatRequest, now: u64) -> Sent {
        let topic = request.topic_name.as_str().ok().and_then(|name| name.rsplit_once('/'));
        let is_known = request.protocol_version == MessageFormatRequest::LATEST_PROTOCOL_VERSION;
        let hash = topic.and_then(|(_, topic)| self.release.hash(topic)).filter(|_| is_known);
        Sent::new(&MessageFormatResponse {
            timestamp: now,
            protocol_version: MessageFormatRequest::LATEST_PROTOCOL_VERSION,
            topic_name: request.topic_name,
            success: hash.is_some(),
            message_hash: hash.unwrap_or_default(),
        })
    }

    /// The slot for a registration: the slot of an earlier registration with the same name, or a free slot.
    fn slot(&self, request: &RegisterExtComponentRequest) -> Option<i8> {
        let is_valid = request.px4_ros2_api_version
            == RegisterExtComponentRequest::LATEST_PX4_ROS2_API_VERSION
            && request.register_arming_check
            && (request.register_mode || !request.register_mode_executor);
        let is_same = |known: &Option<Registration>| {
            known.as_ref().is_some_and(|known| known.reply.name == request.name)
        };
        let same = self.registrations.iter().position(is_same);
        let slot = same.or_else(|| self.registrations.iter().position(Option::is_none));
        slot.filter(|_| is_valid).and_then(|slot| i8::try_from(slot).ok())
    }

    fn unregister(&mut self, message: &UnregisterExtComponent) {
        let slot = usize::try_from(message.arming_check_id).ok();
        if let Some(slot) = slot.and_then(|slot| self.registrations.get_mut(slot)) {
            *slot = None;
        }
        if self.registrations.iter().all(Option::is_none) {
            self.next_request = None;
        }
    }

    /// Handles a reply. If it refuses arming, returns a report about the refusal.
    fn replied(&mut self, reply: &ArmingCheckReply, now: u64) -> Vec<Sent> {
        self.replies += 1;
        let slot = self.registrations.get_mut(usize::from(reply.registration_id));
        let Some(registration) = slot.and_then(Option::as_mut) else { return Vec::new() };
        if reply.request_id == self.id.wrapping_sub(1) {
            registration.has_replied = true;
            registration.missing = 0;
        }
        let reasons = reply.events.iter().take(reply.num_events.into());
        let reasons: Vec<Event> = reasons.filter(|_| !reply.can_arm_and_run).cloned().collect();
        if reasons.is_empty() { Vec::new() } else { self.report(&reasons, now) }
    }

    fn request(&mut self, now: u64) -> Sent {
        for registration in self.registrations.iter_mut().flatten() {
            registration.missing = registration.missing.saturating_add(u8::from(!registration.has_replied));
            registration.has_replied = false;
        }
        let trial = if self.purpose == Purpose::Judge { Some(self.count % CYCLE) } else { None };
        let is_revoked = trial.is_some_and(|trial| REVOKED.contains(&trial));
        if trial == Some(SKIPPED) {
            self.id = self.id.wrapping_add(1);
        }
        let request = ArmingCheckRequest {
            timestamp: now,
            request_id: self.id,
            valid_registrations_mask: if is_revoked { 0 } else { self.mask() },
        };
        self.id = self.id.wrapping_add(1);
        self.count += 1;
        self.next_request = Some(now + if trial == Some(HURRIED) { SHORT_INTERVAL } else { INTERVAL });
        Sent::new(&request)
    }

    /// The mask of the registrations whose components respond.
    fn mask(&self) -> u32 {
        let slots = (0_u32..).zip(&self.registrations);
        let is_valid =
            |known: &Option<Registration>| known.as_ref().is_some_and(|known| known.missing < MAX_MISSING);
        slots.filter(|(_, known)| is_valid(known)).map(|(slot, _)| 1 << slot).sum()
    }

    /// The health and arming report, with these reasons for a refusal. Empty for a judge, which publishes no report.
    fn report(&mut self, reasons: &[Event], now: u64) -> Vec<Sent> {
        if self.purpose == Purpose::Judge {
            return Vec::new();
        }
        let modes = NavigationModeGroup(if reasons.is_empty() { ALL_MODES } else { 0 });
        let start = CommanderArmingCheckSummary { can_arm: modes, can_run: modes, ..Default::default() };
        let end = CommanderHealthSummary { is_present: HealthComponent::GPS, ..Default::default() };
        let summary = |id, arguments| Event { id, arguments, log_levels: PROTOCOL, ..Event::default() };
        let start = summary(CommanderArmingCheckSummary::ID, start.encode());
        let end = summary(CommanderHealthSummary::ID, end.encode());
        let events = [start].into_iter().chain(reasons.iter().cloned()).chain([end]);
        let numbered = |event| {
            self.events = self.events.wrapping_add(1);
            Sent::new(&Event { timestamp: now, event_sequence: self.events, ..event })
        };
        events.map(numbered).collect()
    }

    fn state(&mut self, now: u64) -> [Sent; 3] {
        self.next_state = Some(now + STATE_INTERVAL);
        let status = Sent::json(VEHICLE_STATUS, vehicle_status(now));
        [Sent::new(&battery(now)), Sent::new(&failsafe_flags(now)), status]
    }
}

impl Role for Autopilot {
    fn folder(&self) -> &'static str {
        "out"
    }

    fn published(&self) -> &'static [&'static str] {
        if self.purpose == Purpose::Judge { JUDGE } else { REFERENCE }
    }

    fn received(&self) -> &'static [&'static str] {
        RECEIVED
    }

    fn receive(&mut self, message: &Sent, now: u64) -> Vec<Sent> {
        if let Some(request) = message.read::<RegisterExtComponentRequest>() {
            return self.register(&request, now);
        }
        if let Some(request) = message.read::<MessageFormatRequest>() {
            return vec![self.answer_format(&request, now)];
        }
        if let Some(message) = message.read::<UnregisterExtComponent>() {
            self.unregister(&message);
        }
        let reply = message.read::<ArmingCheckReply>();
        reply.map(|reply| self.replied(&reply, now)).unwrap_or_default()
    }

    fn tick(&mut self, now: u64) -> Vec<Sent> {
        let is_due = |time: Option<u64>| time.is_some_and(|time| time <= now);
        let mut sent = Vec::new();
        if is_due(self.next_request) {
            sent.push(self.request(now));
        }
        if is_due(self.next_state) {
            sent.extend(self.state(now));
        }
        sent
    }

    fn next_tick(&self) -> Option<u64> {
        self.next_request.into_iter().chain(self.next_state).min()
    }

    fn notes(&self) -> Vec<String> {
        let note = match (self.count, self.replies) {
            (0, _) => "no component registered",
            (_, 0) => "no component answered an arming check request",
            _ => return Vec::new(),
        };
        vec![note.to_owned()]
    }
}

/// A healthy battery.
fn battery(now: u64) -> BatteryStatus {
    let mut battery = BatteryStatus {
        timestamp: now,
        connected: true,
        voltage_v: 16.2,
        voltage_filtered_v: 16.2,
        current_a: 1.5,
        current_filtered_a: 1.5,
        current_average_a: 1.5,
        discharged_mah: 400.0,
        remaining: 0.9,
        scale: 1.0,
        time_remaining_s: f32::NAN,
        temperature: 25.0,
        cell_count: 4,
        capacity: 5_000,
        state_of_health: 98,
        max_error: 1,
        id: 1,
        warning: BatteryWarning::NONE,
        nominal_voltage: 14.8,
        ..BatteryStatus::default()
    };
    battery.voltage_cell_v[..4].fill(4.05);
    battery
}

/// The state of a disarmed multicopter.
fn vehicle_status(now: u64) -> Value {
    json!({
        "timestamp": now,
        "arming_state": DISARMED,
        "nav_state": HOLD,
        "nav_state_user_intention": HOLD,
        "nav_state_display": HOLD,
        "valid_nav_states_mask": VALID_MODES,
        "can_set_nav_states_mask": VALID_MODES,
        "vehicle_type": ROTARY_WING,
        "system_type": QUADROTOR,
        "system_id": 1,
        "component_id": 1,
        "pre_flight_checks_pass": true,
        "safety_off": true,
        "power_input_valid": true,
    })
}

/// The flags of a vehicle that is on the ground and has no radio.
fn failsafe_flags(now: u64) -> FailsafeFlags {
    FailsafeFlags {
        timestamp: now,
        mode_req_angular_velocity: ALL_MODES,
        mode_req_attitude: ALL_MODES,
        mode_req_manual_control: 0b111,
        manual_control_signal_lost: true,
        ..FailsafeFlags::default()
    }
}

#[cfg(test)]
mod tests {
    use uavspec_rules::definitions::Library;
    use uavspec_runtime::Message;

    use super::*;
    use crate::vehicle::Namespace;

    fn autopilot(purpose: Purpose) -> Autopilot {
        let library = Library::built_in();
        Autopilot::new(purpose, 0, Arc::new(Release::new(library.base(), &library, Namespace::default())))
    }

    fn registration(name: &str, id: u64) -> Sent {
        Sent::new(&RegisterExtComponentRequest {
            request_id: id,
            name: name.parse().expect("a name"),
            px4_ros2_api_version: 1,
            register_arming_check: true,
            ..RegisterExtComponentRequest::default()
        })
    }

    fn registered(autopilot: &mut Autopilot, name: &str) -> RegisterExtComponentReply {
        let sent = autopilot.receive(&registration(name, 7), 0);
        sent[0].read().expect("a reply")
    }

    fn requests(autopilot: &mut Autopilot, count: usize, answers: bool) -> Vec<ArmingCheckRequest> {
        let mut requests = Vec::new();
        while requests.len() < count {
            let now = autopilot.next_tick().expect("a time");
            let request: ArmingCheckRequest = autopilot.tick(now)[0].read().expect("a request");
            if answers {
                let reply =
                    ArmingCheckReply { request_id: request.request_id, ..ArmingCheckReply::default() };
                autopilot.receive(&Sent::new(&reply), now);
            }
            requests.push(request);
        }
        requests
    }

    #[test]
    fn accepts_eight_components() {
        let mut autopilot = autopilot(Purpose::Judge);
        for number in 0..8 {
            let reply = registered(&mut autopilot, &format!("component {number}"));
            assert_eq!((reply.success, reply.arming_check_id), (true, number));
        }
        let reply = registered(&mut autopilot, "another");
        assert_eq!((reply.success, reply.arming_check_id, reply.request_id), (false, INVALID, 7));
        assert_eq!(registered(&mut autopilot, "component 3").arming_check_id, 3);
        autopilot
            .receive(&Sent::new(&UnregisterExtComponent { arming_check_id: 2, ..Default::default() }), 0);
        assert_eq!(registered(&mut autopilot, "another").arming_check_id, 2);
    }

    #[test]
    fn a_component_without_replies_is_unresponsive() {
        let mut autopilot = autopilot(Purpose::Reference);
        autopilot.next_state = None;
        registered(&mut autopilot, "silent");
        let masks: Vec<u32> = requests(&mut autopilot, 5, false)
            .iter()
            .map(|request| request.valid_registrations_mask)
            .collect();
        assert_eq!(masks, [1, 1, 1, 0, 0]);
        requests(&mut autopilot, 1, true);
        assert_eq!(requests(&mut autopilot, 1, true)[0].valid_registrations_mask, 1);
    }

    #[test]
    fn a_judge_sends_unusual_requests() {
        let mut autopilot = autopilot(Purpose::Judge);
        registered(&mut autopilot, "component");
        let requests = requests(&mut autopilot, 24, true);
        let pairs = || requests.iter().zip(&requests[1..]);
        let intervals: Vec<u64> = pairs().map(|(one, next)| next.timestamp - one.timestamp).collect();
        assert_eq!(intervals.iter().filter(|interval| **interval == SHORT_INTERVAL).count(), 1);
        assert!(intervals.iter().all(|interval| [SHORT_INTERVAL, INTERVAL].contains(interval)));
        let steps: Vec<u8> =
            pairs().map(|(one, next)| next.request_id.wrapping_sub(one.request_id)).collect();
        assert_eq!(steps.iter().position(|step| *step == 2), Some(8));
        assert!(!steps[9..].contains(&2));
        assert!(requests.iter().any(|request| request.request_id == 255));
        assert!(requests.iter().any(|request| request.request_id == 0));
        let revoked = requests.iter().filter(|request| request.valid_registrations_mask == 0);
        assert_eq!(revoked.count(), 2);
    }

    #[test]
    fn published_values_conform() {
        assert_eq!(battery(1).validate(), []);
        assert_eq!(failsafe_flags(1).validate(), []);
    }
}
