//! Connects a role to a bus.

use std::collections::HashMap;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher as _, Hasher as _};
use std::sync::Arc;
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;
use uavspec_model::{Endpoint, EndpointKind, Qos, Reliability};
use uavspec_rules::px4::{Bug, Sent, Side};

use super::autopilot::Autopilot;
use super::component::Component;
use super::release::Release;
use super::role::{Purpose, Role};
use crate::bus::{Bus, Encoding, Event, Publisher, Received, Topic, nanoseconds};

/// The time since boot at which a role starts, in µs. It isn't 0, because 0 means that the time is unknown.
const BOOT: u64 = 10_000_000;

/// The maximum time for which a due message is postponed until all received messages have been handled. If it weren't
/// postponed, a reply that was received in time could be recorded after the next request.
const MAX_POSTPONED: Duration = Duration::from_secs(2);

/// The maximum number of problems.
const MAX_PROBLEMS: usize = 16;

/// A hash that no type has.
const OTHER_HASH: &str = "RIHS01_0000000000000000000000000000000000000000000000000000000000000000";

/// A role on a bus.
pub(super) struct Actor {
    role: Box<dyn Role>,
    release: Arc<Release>,
    bug: Option<&'static Bug>,
    clock: Clock,
    started: Instant,
    /// The publisher, the topic and the number of messages of each published type.
    outputs: HashMap<&'static str, Output>,
    /// The types of the subscribed topics.
    inputs: HashMap<String, &'static str>,
    /// Problems with publishing.
    pub(super) problems: Vec<String>,
    /// Problems with received messages.
    remarks: Vec<String>,
}

struct Output {
    publisher: Publisher,
    topic: Topic,
    count: u64,
}

/// The events of a step.
pub(super) struct Step {
    /// The event that was received from the bus.
    pub received: Option<Event>,
    /// The messages that the roles sent.
    pub sent: Vec<Event>,
}

/// Waits for an event until the deadline, and lets the roles react.
pub(super) fn step(actors: &mut [Actor], bus: &mut dyn Bus, deadline: Instant) -> Step {
    let due = actors.iter().filter_map(Actor::due).min();
    let received = bus.receive(due.map_or(deadline, |due| due.min(deadline)));
    let sent = actors.iter_mut().flat_map(|actor| actor.react(bus, received.as_ref())).collect();
    Step { received, sent }
}

impl Actor {
    /// Announces the topics of a role, in a release. Also returns its endpoints.
    pub(super) fn join(
        bus: &mut dyn Bus,
        role: Box<dyn Role>,
        release: Arc<Release>,
        bug: Option<&'static Bug>,
    ) -> Result<(Self, Vec<Event>), String> {
        let clock = bus.clock();
        let (started, outputs, inputs) = (clock.now(), HashMap::new(), HashMap::new());
        let (problems, remarks) = (Vec::new(), Vec::new());
        let mut actor = Self { role, release, bug, clock, started, outputs, inputs, problems, remarks };
        let (sending, receiving) = if actor.role.folder() == "in" { ("in", "out") } else { ("out", "in") };
        let mut endpoints = Vec::new();
        for (index, name) in actor.role.received().iter().enumerate() {
            let (topic, qos) = (actor.release.topic(name, receiving)?, requested(index, bug));
            bus.subscribe(&topic, &qos)?;
            actor.inputs.insert(topic.name.to_string(), name);
            // The probe adapts to the vehicle.
            endpoints.push(endpoint(EndpointKind::Subscriber, &topic, qos, false));
        }
        // An autopilot offers the same quality of service as PX4. Components choose their own.
        let is_matched_by_qos = bus.is_matched_by_qos() && sending == "out";
        for (index, name) in actor.role.published().iter().enumerate() {
            let topic = actor.release.topic(name, sending)?;
            let publisher = bus.advertise(&topic, &Qos::PX4)?;
            if index == 0 && bug.is_some_and(Bug::announces_other_type) {
                bus.advertise(&Topic { type_hash: Some(OTHER_HASH.into()), ..topic.clone() }, &Qos::PX4)?;
            }
            endpoints.push(endpoint(EndpointKind::Publisher, &topic, Qos::PX4, is_matched_by_qos));
            actor.outputs.insert(name, Output { publisher, topic, count: 0 });
        }
        Ok((actor, endpoints))
    }

    /// Passes the endpoints that were discovered earlier to the role.
    pub(super) fn discover(&mut self, endpoints: &[Endpoint]) {
        let now = self.now();
        for endpoint in endpoints {
            self.role.discovered(endpoint, now);
        }
    }

    /// The time at which the next messages are due.
    fn due(&self) -> Option<Instant> {
        self.role.next_tick().map(|due| self.time_of(due))
    }

    /// Lets the role react to an event. If there is no event, also sends the messages that are due.
    fn react(&mut self, bus: &mut dyn Bus, received: Option<&Event>) -> Vec<Event> {
        let due = self.due();
        let mut sent = match received {
            Some(Event::Message(message)) => self.receive(bus, message),
            Some(Event::Endpoint(endpoint)) => {
                self.role.discovered(endpoint, self.now());
                Vec::new()
            }
            _ => Vec::new(),
        };
        let margin = if received.is_some() { MAX_POSTPONED } else { Duration::ZERO };
        if due.is_some_and(|due| due + margin <= self.clock.now()) {
            let messages = self.role.tick(self.now());
            sent.extend(self.send(bus, messages));
        }
        sent
    }

    /// Ends the role.
    pub(super) fn leave(&mut self, bus: &mut dyn Bus) -> Vec<Event> {
        let messages = self.role.leave();
        self.send(bus, messages)
    }

    /// Notable events for the report.
    pub(super) fn notes(&self) -> Vec<String> {
        self.remarks.iter().cloned().chain(self.role.notes()).collect()
    }

    fn receive(&mut self, bus: &mut dyn Bus, message: &Received) -> Vec<Event> {
        let Some(name) = self.inputs.get(&*message.topic.name) else { return Vec::new() };
        let decoded = match message.encoding {
            Encoding::Cdr => self.release.decode(name, &message.payload),
            Encoding::Json => Err("a role can't read JSON messages".to_owned()),
        };
        match decoded {
            Ok(message) => {
                let replies = self.role.receive(&message, self.now());
                self.send(bus, replies)
            }
            Err(problem) => {
                note(&mut self.remarks, format!("{}: {problem}", message.topic.name.escape_debug()));
                Vec::new()
            }
        }
    }

    fn send(&mut self, bus: &mut dyn Bus, messages: Vec<Sent>) -> Vec<Event> {
        let mut sent = Vec::new();
        for message in messages {
            let Some(output) = self.outputs.get_mut(message.name) else { continue };
            output.count += 1;
            let messages = match self.bug {
                Some(bug) => bug.apply(message, output.count),
                None => vec![message],
            };
            for message in messages {
                let payload = self.release.encode(&message);
                let published = payload.and_then(|payload| {
                    bus.publish(output.publisher, &payload)?;
                    Ok(payload)
                });
                match published {
                    Ok(payload) => sent.push(recorded(&output.topic, payload, &self.clock)),
                    Err(problem) => note(&mut self.problems, format!("{}: {problem}", output.topic.name)),
                }
            }
        }
        sent
    }

    /// The time in µs since boot.
    fn now(&self) -> u64 {
        let elapsed = self.clock.now() - self.started;
        BOOT.saturating_add(u64::try_from(elapsed.as_micros()).unwrap_or(u64::MAX))
    }

    fn time_of(&self, time: u64) -> Instant {
        self.started + Duration::from_micros(time.saturating_sub(BOOT))
    }
}

/// The quality of service that a role requests for the topic with this index.
fn requested(index: usize, bug: Option<&Bug>) -> Qos {
    let is_reliable = index == 0 && bug.is_some_and(Bug::requests_reliable);
    let reliability = if is_reliable { Reliability::Reliable } else { Reliability::BestEffort };
    Qos { reliability, ..Qos::WEAKEST }
}

/// A message of this program, for the recording.
fn recorded(topic: &Topic, payload: Vec<u8>, clock: &Clock) -> Event {
    let message = Received::new(topic.clone(), Encoding::Cdr, nanoseconds(clock), payload);
    Event::Message(Received { is_own: true, ..message })
}

/// An endpoint of this program, for the recording. It has no type hash, so that a vehicle with another release isn't
/// blamed for the definitions of this program.
fn endpoint(kind: EndpointKind, topic: &Topic, qos: Qos, is_matched_by_qos: bool) -> Event {
    Event::Endpoint(Endpoint {
        id: Endpoint::own_id(kind, &topic.name),
        kind,
        node: Some("/uavspec".to_owned()),
        topic: topic.name.to_string(),
        type_name: topic.type_name.to_string(),
        type_hash: None,
        qos: Some(qos),
        is_matched_by_qos,
    })
}

fn note(notes: &mut Vec<String>, text: String) {
    if !notes.contains(&text) && notes.len() < MAX_PROBLEMS {
        notes.push(text);
    }
}

/// Creates a role in the arming checks.
pub(super) fn role(side: Side, purpose: Purpose, release: &Arc<Release>) -> Box<dyn Role> {
    match side {
        Side::Autopilot => Box::new(Autopilot::new(purpose, BOOT, Arc::clone(release))),
        Side::Component => {
            // Each `RandomState` has other keys.
            let seed = RandomState::new().build_hasher().finish();
            Box::new(Component::new(purpose, seed, BOOT))
        }
    }
}
