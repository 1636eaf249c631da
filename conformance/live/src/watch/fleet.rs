//! The known state of a fleet and its server. This module does no input or output, so the same events at the same times
//! result in the same fleet.

use std::time::{Duration, Instant};

use uavspec_runtime::Severity;

use super::message::{Content, Message};
use super::rate::Rate;
use super::roster::Roster;
use super::session::Event;
use super::state::State;

/// A UAV.
#[derive(Debug, Default)]
pub(crate) struct Uav {
    /// The last reported state.
    pub state: Option<State>,
    /// The server's reason for not reporting the UAV's state, if it refused.
    pub refusal: Option<String>,
    /// The time at which the state's timestamp last changed.
    changed: Option<Instant>,
}

impl Uav {
    /// The highest severity among the UAV's error codes.
    pub(crate) fn worst(&self) -> Option<Severity> {
        self.codes().first().map(|code| Severity::of(*code))
    }

    /// The UAV's error codes, most severe first.
    pub(crate) fn codes(&self) -> &[u32] {
        let errors = self.state.as_ref().and_then(|state| state.errors.known());
        errors.map_or(&[], |errors| &errors.codes)
    }

    fn take(&mut self, state: Result<State, String>, now: Instant) {
        match state {
            Ok(state) => {
                let timestamp = |state: &State| state.timestamp.known().copied();
                let known = self.state.as_ref().and_then(timestamp);
                if self.changed.is_none() || known.is_none() || known != timestamp(&state) {
                    self.changed = Some(now);
                }
                self.refusal = None;
                self.state = Some(state);
            }
            Err(reason) => self.refusal = Some(reason),
        }
    }
}

/// The state of the connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Link {
    /// No message has been received yet.
    #[default]
    Connecting,
    /// The server responds.
    Connected,
    /// The connection was lost.
    Lost {
        /// The reason.
        reason: String,
        /// The time of the next attempt to connect.
        again: Instant,
    },
}

/// A fleet.
#[derive(Debug, Default)]
pub struct Fleet {
    /// The state of the connection.
    pub link: Link,
    /// The server software and its version.
    pub server: Option<String>,
    /// The server's last refusal, or another remark.
    pub remark: Option<String>,
    /// The number of unreadable messages.
    pub unreadable: u64,
    /// True if the server has more UAVs than the limit allows.
    pub is_overfull: bool,
    /// True if the server has sent a list of its UAVs.
    has_list: bool,
    clock: Option<(Instant, i64)>,
    /// The time of the first message.
    first: Option<Instant>,
    rate: Rate,
    uavs: Roster<Uav>,
}

impl Fleet {
    /// Applies an event.
    pub fn take(&mut self, event: Event, now: Instant) {
        match event {
            Event::Lost { reason, pause } => self.link = Link::Lost { reason, again: now + pause },
            Event::Received(message) => self.apply(message, now),
        }
    }

    fn apply(&mut self, message: Message, now: Instant) {
        if self.link != Link::Connected {
            self.link = Link::Connected;
            self.remark = None;
        }
        self.first.get_or_insert(now);
        self.rate.count(self.elapsed(now));
        match message.content {
            Content::Server(server) => self.server = Some(server),
            Content::Time(time) => self.clock = Some((now, time)),
            Content::List(list) => {
                self.has_list = true;
                // The server accepts requests, so an earlier refusal no longer applies.
                self.remark = None;
                self.is_overfull = !self.uavs.update(&list, now);
            }
            Content::States(states) => {
                let is_answer = message.refs.is_some();
                for (id, state) in states {
                    self.update_uav(&id, state, is_answer, now);
                }
            }
            Content::Gone(ids) => ids.iter().for_each(|id| drop(self.uavs.members.remove(id))),
            Content::Closing(reason) => {
                self.remark = Some(format!("the server is closing the connection: {reason}"));
            }
            Content::Refused(reason) => self.remark = Some(format!("the server refused a request: {reason}")),
            Content::Unreadable => self.unreadable = self.unreadable.saturating_add(1),
            Content::Other => {}
        }
    }

    fn update_uav(&mut self, id: &str, state: Result<State, String>, is_answer: bool, now: Instant) {
        let known = if state.is_ok() { self.uavs.admit(id) } else { self.uavs.members.get_mut(id) };
        match known {
            Some(member) => {
                if state.is_ok() && !is_answer {
                    member.last_reported = Some(now);
                }
                member.value.take(state, now);
            }
            None => self.is_overfull |= state.is_ok(),
        }
    }

    /// The number of UAVs.
    pub(crate) fn len(&self) -> usize {
        self.uavs.members.len()
    }

    /// True if there are no UAVs.
    pub fn is_empty(&self) -> bool {
        self.uavs.members.is_empty()
    }

    /// The UAVs with their ids.
    pub(crate) fn uavs(&self) -> impl Iterator<Item = (&str, &Uav)> {
        self.uavs.members.iter().map(|(id, member)| (id.as_str(), &member.value))
    }

    /// The UAV with this id.
    pub(crate) fn get(&self, id: &str) -> Option<&Uav> {
        self.uavs.members.get(id).map(|member| &member.value)
    }

    /// True if the server has sent a list of its UAVs, and a state or refusal for each UAV.
    pub fn is_complete(&self) -> bool {
        let is_known = |uav: &Uav| uav.state.is_some() || uav.refusal.is_some();
        self.has_list && self.uavs().all(|(_, uav)| is_known(uav))
    }

    /// The age of a UAV's state. If the server's clock is known, the age is computed from the timestamp. Otherwise, it
    /// is the time since the timestamp last changed.
    pub(crate) fn age(&self, uav: &Uav, now: Instant) -> Option<Duration> {
        let since = now.saturating_duration_since(uav.changed?);
        let timestamp = uav.state.as_ref().and_then(|state| state.timestamp.known());
        let by_clock = self.clock.zip(timestamp).and_then(|((at, time), timestamp)| {
            let passed = i64::try_from(now.saturating_duration_since(at).as_millis()).unwrap_or(i64::MAX);
            // If a timestamp is ahead of the server's clock, the age is unknown.
            u64::try_from(time.saturating_add(passed).saturating_sub(*timestamp)).ok()
        });
        Some(by_clock.map_or(since, Duration::from_millis))
    }

    /// The number of messages per second.
    pub(crate) fn rate(&self, now: Instant) -> f64 {
        self.rate.per_second(self.elapsed(now))
    }

    /// The time since the first message.
    fn elapsed(&self, now: Instant) -> Duration {
        self.first.map_or(Duration::ZERO, |first| now.saturating_duration_since(first))
    }

    /// The number of UAVs whose most severe error code has this severity.
    pub(crate) fn count(&self, severity: Severity) -> usize {
        self.uavs().filter(|(_, uav)| uav.worst() == Some(severity)).count()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use uavspec_model::clock::Clock;
    use uavspec_test_support::extent;

    use super::*;
    use crate::limits::MAX_UAVS;

    fn received(text: &str) -> Event {
        Event::Received(Message::read(text.as_bytes()))
    }

    fn receive(fleet: &mut Fleet, text: &str, now: Instant) {
        fleet.take(received(text), now);
    }

    fn ids(fleet: &Fleet) -> Vec<&str> {
        fleet.uavs().map(|(id, _)| id).collect()
    }

    #[test]
    fn uavs_join_and_leave_the_fleet() {
        let now = Clock::simulated().now();
        let mut fleet = Fleet::default();
        assert!(!fleet.is_complete());
        receive(&mut fleet, r#"{"type": "UAV-LIST", "ids": ["glider-1", "glider-2"]}"#, now);
        assert_eq!((ids(&fleet), fleet.is_complete()), (vec!["glider-1", "glider-2"], false));
        let states = r#"{"type": "UAV-INF", "status": {"glider-1": {"errors": [1, 199]}, "kite": {}},
                         "error": {"glider-2": "no signal", "nobody": "unknown"}}"#;
        receive(&mut fleet, states, now);
        assert_eq!((ids(&fleet), fleet.is_complete()), (vec!["glider-1", "glider-2", "kite"], true));
        assert_eq!(fleet.get("glider-2").and_then(|uav| uav.refusal.as_deref()), Some("no signal"));
        assert_eq!((fleet.count(Severity::Fatal), fleet.count(Severity::Informational)), (1, 0));
        receive(&mut fleet, r#"{"type": "OBJ-DEL", "ids": ["kite", "nobody"]}"#, now);
        assert_eq!(ids(&fleet), ["glider-1", "glider-2"]);
        receive(&mut fleet, r#"{"type": "UAV-LIST", "ids": ["glider-2"]}"#, now + Duration::from_secs(20));
        assert_eq!(ids(&fleet), ["glider-2"]);
        fleet.take(Event::Lost { reason: "it ended".to_owned(), pause: Duration::from_secs(1) }, now);
        assert_eq!((fleet.len(), fleet.is_empty()), (1, false), "known UAVs remain");
        assert!(matches!(fleet.link, Link::Lost { .. }));
    }

    #[test]
    fn a_uav_ages_while_its_timestamp_does_not_change() {
        let start = Clock::simulated().now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let age = |fleet: &Fleet, seconds: u64| {
            fleet.get("glider-1").and_then(|uav| fleet.age(uav, at(seconds))).map(|age| age.as_secs())
        };
        let state = |timestamp: &str| {
            format!(r#"{{"type": "UAV-INF", "status": {{"glider-1": {{"timestamp": {timestamp}}}}}}}"#)
        };
        let mut fleet = Fleet::default();
        receive(&mut fleet, r#"{"type": "UAV-LIST", "ids": ["glider-1"]}"#, at(0));
        assert_eq!(age(&fleet, 1), None);
        for seconds in [0, 5] {
            receive(&mut fleet, &state("60000"), at(seconds));
            assert_eq!(age(&fleet, seconds + 2), Some(seconds + 2));
        }
        receive(&mut fleet, r#"{"type": "SYS-TIME", "timestamp": 70000}"#, at(6));
        assert_eq!(age(&fleet, 7), Some(11), "the state was 10 s old when it was received");
        receive(&mut fleet, &state("71500"), at(8));
        assert_eq!(age(&fleet, 9), Some(1), "the timestamp is later than the server's clock");
        receive(&mut fleet, &state("\"soon\""), at(10));
        receive(&mut fleet, &state("\"soon\""), at(20));
        assert_eq!(age(&fleet, 21), Some(1), "without a timestamp, every state is new");
    }

    #[test]
    fn the_number_of_uavs_is_limited() {
        let now = Clock::simulated().now();
        let mut fleet = Fleet::default();
        for number in 0..MAX_UAVS + 500 {
            receive(&mut fleet, &format!(r#"{{"type": "UAV-INF", "status": {{"{number}": {{}}}}}}"#), now);
        }
        assert_eq!((fleet.len(), fleet.is_overfull), (MAX_UAVS, true));
        receive(&mut fleet, r#"{"type": "UAV-LIST", "ids": ["glider-1"]}"#, now + Duration::from_secs(20));
        assert_eq!((ids(&fleet), fleet.is_overfull), (vec!["glider-1"], false));
    }

    /// Arbitrary JSON whose keys include the keys of messages.
    fn json() -> impl Strategy<Value = serde_json::Value> {
        let key = prop_oneof![
            Just("body".to_owned()),
            Just("type".to_owned()),
            Just("ids".to_owned()),
            Just("status".to_owned()),
            Just("error".to_owned()),
            Just("errors".to_owned()),
            Just("battery".to_owned()),
            Just("position".to_owned()),
            Just("timestamp".to_owned()),
            any::<String>(),
        ];
        let leaf = prop_oneof![
            any::<i64>().prop_map(Into::into),
            any::<f64>().prop_map(Into::into),
            any::<bool>().prop_map(Into::into),
            Just(serde_json::Value::Null),
            "UAV-INF|UAV-LIST|OBJ-DEL|SYS-TIME|SYS-VER|ACK-NAK".prop_map(Into::into),
            any::<String>().prop_map(Into::into),
        ];
        leaf.prop_recursive(5, 60, 8, move |inner| {
            prop_oneof![
                proptest::collection::vec(inner.clone(), 0..6).prop_map(Into::into),
                proptest::collection::vec((key.clone(), inner), 0..6)
                    .prop_map(|members| { serde_json::Value::Object(members.into_iter().collect()) }),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(extent(256, 96)))]

        #[test]
        fn accepts_arbitrary_messages(
            messages in proptest::collection::vec((json(), "UAV-INF|UAV-LIST|OBJ-DEL|SYS-TIME"), 1..8),
        ) {
            let start = Clock::simulated().now();
            let mut fleet = Fleet::default();
            for (number, (mut message, kind)) in messages.into_iter().enumerate() {
                if let Some(message) = message.as_object_mut() {
                    message.insert("type".to_owned(), kind.into());
                }
                let now = start + Duration::from_secs(number as u64);
                receive(&mut fleet, &message.to_string(), now);
                let uavs: Vec<_> = fleet.uavs().collect();
                for (_, uav) in uavs {
                    let _ = fleet.age(uav, now);
                }
            }
            prop_assert!(fleet.len() <= MAX_UAVS);
        }
    }
}
