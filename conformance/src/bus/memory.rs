//! A bus within a process, for tests.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::{Bus, Encoding, Event, Publisher, Received, Topic, now};
use crate::model::{Durability, Endpoint, EndpointKind, Qos};

/// A network that connects buses.
#[derive(Clone, Default)]
pub(crate) struct Network(Arc<Shared>);

#[derive(Default)]
struct Shared {
    members: Mutex<Vec<Member>>,
    changed: Condvar,
}

/// The state of a bus.
#[derive(Default)]
struct Member {
    node: String,
    endpoints: Vec<Endpoint>,
    subscribed: Vec<Arc<str>>,
    events: VecDeque<Event>,
}

/// A connection to a network.
pub(crate) struct MemoryBus {
    network: Network,
    index: usize,
    published: Vec<Topic>,
}

impl Network {
    /// Connects a node. It learns about the endpoints of all other nodes.
    pub(crate) fn connect(&self, node: &str) -> MemoryBus {
        let mut members = self.members();
        let known = members.iter().flat_map(|member| member.endpoints.iter().cloned().map(Event::Endpoint));
        let events = known.collect();
        members.push(Member { node: node.to_owned(), events, ..Member::default() });
        MemoryBus { network: self.clone(), index: members.len() - 1, published: Vec::new() }
    }

    /// Sends an event to all nodes except one.
    pub(crate) fn send(&self, event: &Event, from: usize) {
        for (index, member) in self.members().iter_mut().enumerate() {
            let is_subscribed = match event {
                Event::Message(message) => member.subscribed.contains(&message.topic.name),
                _ => true,
            };
            if index != from && is_subscribed {
                member.events.push_back(event.clone());
            }
        }
        self.0.changed.notify_all();
    }

    fn members(&self) -> MutexGuard<'_, Vec<Member>> {
        self.0.members.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MemoryBus {
    /// Announces an endpoint of this node.
    pub(crate) fn announce(&self, kind: EndpointKind, topic: &Topic, qos: &Qos) {
        let mut members = self.network.members();
        let member = &mut members[self.index];
        let endpoint = Endpoint {
            id: format!("{}.{}", self.index, member.endpoints.len()),
            kind,
            node: Some(member.node.clone()),
            topic: topic.name.to_string(),
            type_name: topic.type_name.to_string(),
            type_hash: topic.type_hash.as_ref().map(ToString::to_string),
            qos: Some(qos.clone()),
            is_matched_by_qos: true,
        };
        member.endpoints.push(endpoint.clone());
        drop(members);
        self.network.send(&Event::Endpoint(endpoint), self.index);
    }
}

impl Bus for MemoryBus {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        let mut members = self.network.members();
        loop {
            if let Some(event) = members[self.index].events.pop_front() {
                return Some(event);
            }
            let time = deadline.checked_duration_since(Instant::now()).filter(|time| !time.is_zero())?;
            let waited = self.network.0.changed.wait_timeout(members, time);
            members = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn subscribe(&mut self, topic: &Topic) -> Result<(), String> {
        let is_new = {
            let subscribed = &mut self.network.members()[self.index].subscribed;
            let is_new = !subscribed.contains(&topic.name);
            subscribed.push(Arc::clone(&topic.name));
            is_new
        };
        if is_new {
            let weakest = Qos { durability: Durability::Volatile, ..Qos::PX4 };
            self.announce(EndpointKind::Subscriber, topic, &weakest);
        }
        Ok(())
    }

    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String> {
        self.announce(EndpointKind::Publisher, topic, qos);
        self.published.push(topic.clone());
        Ok(Publisher(self.published.len() - 1))
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        let topic = self.published.get(publisher.0).ok_or("an unknown publisher")?.clone();
        let (time, payload) = (now(), payload.to_vec());
        let message = Received { topic, schema: None, encoding: Encoding::Cdr, time, payload };
        self.network.send(&Event::Message(message), self.index);
        Ok(())
    }
}

impl Drop for MemoryBus {
    fn drop(&mut self) {
        let endpoints = std::mem::take(&mut self.network.members()[self.index].endpoints);
        for endpoint in endpoints {
            self.network.send(&Event::Ended(endpoint.id), self.index);
        }
    }
}
