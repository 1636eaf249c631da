//! A bus within a process, for the self-test and for tests. Like DDS, it compares the quality of service. Like Zenoh,
//! it announces type hashes. Its threads wait in simulated time.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;
use uavspec_model::{Endpoint, EndpointKind, Qos};

use super::{Bus, Encoding, Event, Publisher, Received, Topic, nanoseconds};

/// The interval between checks for events. It matters only in real time, in which no user runs this bus.
const INTERVAL: Duration = Duration::from_millis(1);

/// A network that connects buses.
#[derive(Clone, Default)]
pub struct Network(Arc<Mutex<Vec<Member>>>);

/// The state of a bus.
#[derive(Default)]
struct Member {
    is_connected: bool,
    node: String,
    endpoints: Vec<Endpoint>,
    /// The quality of service that the bus requests, by topic.
    subscribed: HashMap<Arc<str>, Qos>,
    events: VecDeque<Event>,
}

/// A connection to a network.
pub struct MemoryBus {
    network: Network,
    clock: Clock,
    index: usize,
    published: Vec<(Topic, Qos)>,
}

impl Network {
    /// Connects a node. It learns about the endpoints of all other nodes.
    pub fn connect(&self, node: &str, clock: &Clock) -> MemoryBus {
        let mut members = self.members();
        let known = members.iter().flat_map(|member| member.endpoints.iter().cloned().map(Event::Endpoint));
        let events = known.collect();
        members.push(Member { is_connected: true, node: node.to_owned(), events, ..Member::default() });
        let index = members.len() - 1;
        MemoryBus { network: self.clone(), clock: clock.clone(), index, published: Vec::new() }
    }

    /// Sends an event to all nodes except one.
    pub(crate) fn send(&self, event: &Event, from: usize) {
        self.send_if(event, from, |_| true);
    }

    /// Sends an event to all nodes that meet a condition, except one.
    fn send_if(&self, event: &Event, from: usize, is_receiver: impl Fn(&Member) -> bool) {
        for (index, member) in self.members().iter_mut().enumerate() {
            if index != from && member.is_connected && is_receiver(member) {
                member.events.push_back(event.clone());
            }
        }
    }

    fn members(&self) -> MutexGuard<'_, Vec<Member>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MemoryBus {
    /// Announces an endpoint of this node.
    fn announce(&self, kind: EndpointKind, topic: &Topic, qos: &Qos) {
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
        self.clock.poll(deadline, INTERVAL, || self.network.members()[self.index].events.pop_front())
    }

    fn subscribe(&mut self, topic: &Topic, qos: &Qos) -> Result<(), String> {
        if let Entry::Vacant(place) =
            self.network.members()[self.index].subscribed.entry(Arc::clone(&topic.name))
        {
            place.insert(qos.clone());
        } else {
            return Ok(());
        }
        self.announce(EndpointKind::Subscriber, topic, qos);
        Ok(())
    }

    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String> {
        self.announce(EndpointKind::Publisher, topic, qos);
        self.published.push((topic.clone(), qos.clone()));
        Ok(Publisher(self.published.len() - 1))
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        let (topic, offered) = self.published.get(publisher.0).ok_or("an unknown publisher")?.clone();
        let name = Arc::clone(&topic.name);
        let message = Received::new(topic, Encoding::Cdr, nanoseconds(&self.clock), payload.to_vec());
        self.network.send_if(&Event::Message(message), self.index, |member| {
            member.subscribed.get(&name).is_some_and(|requested| is_compatible(&offered, requested))
        });
        Ok(())
    }

    fn clock(&self) -> Clock {
        self.clock.clone()
    }

    fn is_matched_by_qos(&self) -> bool {
        true
    }
}

impl Drop for MemoryBus {
    fn drop(&mut self) {
        let Member { endpoints, .. } = std::mem::take(&mut self.network.members()[self.index]);
        for endpoint in endpoints {
            self.network.send(&Event::Ended(endpoint.id), self.index);
        }
    }
}

/// True if the quality of service of a publisher meets the request of a subscriber. Compares only the policies that the
/// participants of a network use.
fn is_compatible(offered: &Qos, requested: &Qos) -> bool {
    offered.reliability >= requested.reliability && offered.durability >= requested.durability
}

#[cfg(test)]
mod tests {
    use uavspec_model::Reliability;

    use super::*;

    #[test]
    fn reliable_subscribers_of_best_effort_publishers_receive_nothing() {
        let (network, clock) = (Network::default(), Clock::simulated());
        let topic = Topic { name: "/wind".into(), type_name: "sky_msgs/msg/Wind".into(), type_hash: None };
        let [mut sender, mut receiver, mut reliable] =
            ["/a", "/b", "/c"].map(|node| network.connect(node, &clock));
        receiver.subscribe(&topic, &Qos::WEAKEST).expect("a subscriber");
        let qos = Qos { reliability: Reliability::Reliable, ..Qos::WEAKEST };
        reliable.subscribe(&topic, &qos).expect("a subscriber");
        let publisher = sender.advertise(&topic, &Qos::PX4).expect("a publisher");
        sender.publish(publisher, b"wind").expect("published");
        let events =
            |bus: &mut MemoryBus| std::iter::from_fn(|| bus.receive(clock.now())).collect::<Vec<_>>();
        let announced = events(&mut receiver);
        assert!(announced.iter().any(|event| matches!(event, Event::Message(_))));
        let is_announced =
            |event: &Event| matches!(event, Event::Endpoint(endpoint) if endpoint.qos.as_ref() == Some(&qos));
        assert!(announced.iter().any(is_announced));
        assert!(!events(&mut reliable).iter().any(|event| matches!(event, Event::Message(_))));
    }
}
