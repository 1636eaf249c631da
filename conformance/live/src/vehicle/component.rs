//! An external component, which takes part in arming checks. It sends no commands.

use uavspec_rules::px4::Sent;
use uavspec_runtime::event::Event as _;
use uavspec_runtime::{Message as _, Text};
use uavspec_types::px4::{
    ArmingCheckReply, ArmingCheckRequest, Event, RegisterExtComponentReply, RegisterExtComponentRequest,
    UnregisterExtComponent,
};
use uavspec_types::px4_events::px4::{CheckModesGlobalPos, NavigationModeGroup};

use super::role::{Purpose, Role};

/// The types of the messages that a component publishes.
const PUBLISHED: &[&str] =
    &[ArmingCheckReply::NAME, RegisterExtComponentRequest::NAME, UnregisterExtComponent::NAME];

const RECEIVED: &[&str] = &[ArmingCheckRequest::NAME, RegisterExtComponentReply::NAME];

/// The time after which an unanswered registration request is repeated, in µs.
const RETRY_TIME: u64 = 1_000_000;

/// The maximum number of registration requests.
const ATTEMPTS: u8 = 5;

/// The time at which a judge registers its second component, in µs after the start.
const SECOND_START: u64 = 1_200_000;

/// The time for which the second component of a judge stays registered, in µs.
const SECOND_STAY: u64 = 1_500_000;

/// The number of the only reply in which a judge refuses arming.
const REFUSAL: u64 = 4;

/// The number of replies after which a reference refuses arming once.
const REFUSAL_INTERVAL: u64 = 4;

/// The reason for a refusal. It affects all modes, and concerns no component of the vehicle.
const REASON: CheckModesGlobalPos =
    CheckModesGlobalPos { modes: NavigationModeGroup(u32::MAX), health_component_index: 0 };

/// The log levels of the reason: both are "warning".
const WARNING: u8 = 0x44;

/// The external components that a program provides.
pub(super) struct Component {
    purpose: Purpose,
    members: Vec<Member>,
    /// The id and the time of the latest request. The same request may be received twice.
    latest: Option<(u8, u64)>,
}

/// A component.
struct Member {
    name: Text<25>,
    request_id: u64,
    state: State,
    /// The time of the next action. `None` if there is none.
    due: Option<u64>,
    /// The number of registration requests that have been sent.
    attempts: u8,
    /// The time for which the component stays registered. `None` if it stays until the end.
    stay: Option<u64>,
    /// The number of replies to arming checks.
    replies: u64,
}

/// The state of a component.
enum State {
    /// Not registered.
    Unregistered,
    Registered(RegisterExtComponentReply),
    /// The registration was refused, or remained unanswered.
    Failed,
    Left,
}

impl Component {
    pub(super) fn new(purpose: Purpose, seed: u64, now: u64) -> Self {
        let members = match purpose {
            Purpose::Reference => vec![Member::new("uavspec reference", seed, now)],
            Purpose::Judge => vec![
                Member::new("uavspec probe", seed, now),
                Member {
                    stay: Some(SECOND_STAY),
                    ..Member::new("uavspec probe 2", seed.wrapping_add(1), now + SECOND_START)
                },
            ],
        };
        Self { purpose, members, latest: None }
    }

    fn answer(&mut self, request: &ArmingCheckRequest) -> Vec<Sent> {
        let key = (request.request_id, request.timestamp);
        if self.latest.replace(key) == Some(key) {
            return Vec::new();
        }
        let (purpose, members) = (self.purpose, self.members.iter_mut());
        let replies = (0..).zip(members).filter_map(|(index, member)| {
            let is_refused = match purpose {
                Purpose::Judge => index == 0 && member.replies + 1 == REFUSAL,
                Purpose::Reference => (member.replies + 1).is_multiple_of(REFUSAL_INTERVAL),
            };
            member.answer(request.request_id, is_refused)
        });
        replies.collect()
    }
}

impl Member {
    fn new(name: &str, request_id: u64, start: u64) -> Self {
        Self {
            // The names fit.
            name: name.parse().unwrap_or_default(),
            request_id,
            state: State::Unregistered,
            due: Some(start),
            attempts: 0,
            stay: None,
            replies: 0,
        }
    }

    /// Performs the action that is due.
    fn act(&mut self, now: u64) -> Option<Sent> {
        match self.state {
            State::Registered(_) => self.leave(),
            State::Unregistered if self.attempts < ATTEMPTS => {
                self.attempts += 1;
                self.due = Some(now + RETRY_TIME);
                Some(self.request())
            }
            State::Unregistered => {
                (self.state, self.due) = (State::Failed, None);
                None
            }
            State::Failed | State::Left => None,
        }
    }

    /// The registration request. It has no time: the flight controller sets the time of such messages.
    fn request(&self) -> Sent {
        Sent::new(&RegisterExtComponentRequest {
            request_id: self.request_id,
            name: self.name,
            px4_ros2_api_version: RegisterExtComponentRequest::LATEST_PX4_ROS2_API_VERSION,
            register_arming_check: true,
            ..RegisterExtComponentRequest::default()
        })
    }

    fn registered(&mut self, reply: &RegisterExtComponentReply, now: u64) {
        let is_own = reply.request_id == self.request_id && reply.name.bytes() == self.name.bytes();
        if !is_own || !matches!(self.state, State::Unregistered) {
            return;
        }
        self.state = if reply.success { State::Registered(reply.clone()) } else { State::Failed };
        self.due = self.stay.filter(|_| reply.success).map(|stay| now + stay);
    }

    fn answer(&mut self, request_id: u8, is_refused: bool) -> Option<Sent> {
        let State::Registered(registration) = &self.state else { return None };
        let registration_id = u8::try_from(registration.arming_check_id).ok()?;
        self.replies += 1;
        let mut reply = ArmingCheckReply {
            request_id,
            registration_id,
            can_arm_and_run: !is_refused,
            num_events: u8::from(is_refused),
            ..ArmingCheckReply::default()
        };
        if is_refused {
            let (id, arguments) = (CheckModesGlobalPos::ID, REASON.encode());
            reply.events[0] = Event { id, arguments, log_levels: WARNING, ..Event::default() };
        }
        Some(Sent::new(&reply))
    }

    fn leave(&mut self) -> Option<Sent> {
        self.due = None;
        let State::Registered(registration) = std::mem::replace(&mut self.state, State::Left) else {
            return None;
        };
        Some(Sent::new(&UnregisterExtComponent {
            timestamp: 0,
            name: self.name,
            arming_check_id: registration.arming_check_id,
            mode_id: registration.mode_id,
            mode_executor_id: registration.mode_executor_id,
        }))
    }

    fn note(&self) -> Option<String> {
        let name = self.name.as_str().unwrap_or_default();
        match self.state {
            State::Failed if self.attempts == ATTEMPTS => {
                Some(format!("the registration of `{name}` got no reply"))
            }
            State::Failed => Some(format!("the registration of `{name}` was refused")),
            State::Registered(_) | State::Left if self.replies == 0 => {
                Some(format!("no arming check request followed the registration of `{name}`"))
            }
            _ => None,
        }
    }
}

impl Role for Component {
    fn folder(&self) -> &'static str {
        "in"
    }

    fn published(&self) -> &'static [&'static str] {
        PUBLISHED
    }

    fn received(&self) -> &'static [&'static str] {
        RECEIVED
    }

    fn receive(&mut self, message: &Sent, now: u64) -> Vec<Sent> {
        if let Some(reply) = message.read::<RegisterExtComponentReply>() {
            self.members.iter_mut().for_each(|member| member.registered(&reply, now));
        }
        message.read::<ArmingCheckRequest>().map(|request| self.answer(&request)).unwrap_or_default()
    }

    fn tick(&mut self, now: u64) -> Vec<Sent> {
        let due = self.members.iter_mut().filter(|member| member.due.is_some_and(|due| due <= now));
        due.filter_map(|member| member.act(now)).collect()
    }

    fn next_tick(&self) -> Option<u64> {
        self.members.iter().filter_map(|member| member.due).min()
    }

    fn leave(&mut self) -> Vec<Sent> {
        self.members.iter_mut().filter_map(Member::leave).collect()
    }

    fn notes(&self) -> Vec<String> {
        self.members.iter().filter_map(Member::note).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn registration(component: &mut Component, now: u64) -> RegisterExtComponentRequest {
        component.tick(now)[0].read().expect("a request")
    }

    fn register(component: &mut Component, now: u64, id: i8) {
        let request = registration(component, now);
        let reply = RegisterExtComponentReply {
            request_id: request.request_id,
            name: request.name,
            success: true,
            arming_check_id: id,
            ..RegisterExtComponentReply::default()
        };
        component.receive(&Sent::new(&reply), now);
    }

    fn replies(component: &mut Component, id: u8) -> Vec<ArmingCheckReply> {
        let request = ArmingCheckRequest { timestamp: id.into(), request_id: id, ..Default::default() };
        let sent = component.receive(&Sent::new(&request), 0);
        sent.iter().map(|sent| sent.read().expect("a reply")).collect()
    }

    #[test]
    fn repeats_a_registration_without_a_reply() {
        let mut component = Component::new(Purpose::Reference, 5, 0);
        for attempt in 0..5 {
            assert_eq!(component.next_tick(), Some(attempt * RETRY_TIME));
            assert_eq!(registration(&mut component, attempt * RETRY_TIME).request_id, 5);
        }
        assert!(component.tick(5 * RETRY_TIME).is_empty());
        assert_eq!(component.next_tick(), None);
        assert_eq!(component.notes(), ["the registration of `uavspec reference` got no reply"]);
    }

    #[test]
    fn answers_each_request_once() {
        let mut component = Component::new(Purpose::Judge, 5, 0);
        assert!(replies(&mut component, 1).is_empty());
        register(&mut component, 0, 3);
        let found = replies(&mut component, 2);
        assert_eq!((found.len(), found[0].request_id, found[0].registration_id), (1, 2, 3));
        assert!(replies(&mut component, 2).is_empty());
    }

    #[test]
    fn a_judge_refuses_once_with_a_reason() {
        let mut component = Component::new(Purpose::Judge, 5, 0);
        register(&mut component, 0, 3);
        let replies: Vec<_> = (1..20).flat_map(|id| replies(&mut component, id)).collect();
        let refusals: Vec<_> = replies.iter().filter(|reply| !reply.can_arm_and_run).collect();
        assert_eq!((replies.len(), refusals.len()), (19, 1));
        assert_eq!((refusals[0].num_events, refusals[0].events[0].id), (1, CheckModesGlobalPos::ID));
    }

    #[test]
    fn a_judge_registers_a_second_component_for_some_time() {
        let mut component = Component::new(Purpose::Judge, 5, 0);
        register(&mut component, 0, 0);
        assert_eq!(component.next_tick(), Some(SECOND_START));
        register(&mut component, SECOND_START, 1);
        assert_eq!(replies(&mut component, 1).len(), 2);
        let end = component.next_tick().expect("a time");
        let left: UnregisterExtComponent = component.tick(end)[0].read().expect("a message");
        assert_eq!(left.arming_check_id, 1);
        assert_eq!(replies(&mut component, 2).len(), 1);
        let left = component.leave();
        assert_eq!(left.len(), 1);
        assert!(replies(&mut component, 3).is_empty());
    }
}
