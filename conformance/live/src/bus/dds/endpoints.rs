//! The endpoints of other participants.

use std::collections::HashMap;

use rustdds::discovery::{DiscoveredReaderData, DiscoveredWriterData};
use rustdds::{EndpointDescription, GUID, QosPolicies};
use uavspec_model::limits::MAX_NAME;
use uavspec_model::{Durability, Endpoint, EndpointKind, Qos, Reliability};

use super::super::{Event, Topic};
use super::partitions::Partitions;
use super::{names, qos};
use crate::limits::MAX_ENDPOINTS;

/// The prefix of the names of built-in topics. Programs that use this transport subscribe to these topics.
const BUILT_IN: &str = "DCPS";

/// The first 12 bytes of a GUID, which identify the participant.
pub(crate) type Prefix = [u8; 12];

/// The participant of an endpoint.
pub(crate) fn prefix(guid: GUID) -> Prefix {
    let mut prefix = [0; 12];
    prefix.copy_from_slice(&guid.to_bytes()[..12]);
    prefix
}

/// An announced endpoint.
pub(crate) struct Found<'a> {
    kind: EndpointKind,
    pub(crate) guid: GUID,
    topic: &'a str,
    type_name: &'a str,
    qos: QosPolicies,
    user_data: &'a [u8],
}

impl<'a> Found<'a> {
    /// The endpoint of an event.
    pub(crate) fn described(kind: EndpointKind, endpoint: &'a EndpointDescription) -> Self {
        let EndpointDescription { guid, topic_name, type_name, qos, user_data, .. } = endpoint;
        Self { kind, guid: *guid, topic: topic_name, type_name, qos: qos.clone(), user_data }
    }

    /// A publisher that rustdds has discovered.
    pub(crate) fn writer(writer: &'a DiscoveredWriterData) -> Self {
        let data = &writer.publication_topic_data;
        Self {
            kind: EndpointKind::Publisher,
            guid: data.key,
            topic: &data.topic_name,
            type_name: &data.type_name,
            qos: data.qos(),
            user_data: &writer.user_data,
        }
    }

    /// A subscriber that rustdds has discovered.
    pub(crate) fn reader(reader: &'a DiscoveredReaderData) -> Self {
        let data = &reader.subscription_topic_data;
        Self {
            kind: EndpointKind::Subscriber,
            guid: data.key(),
            topic: data.topic_name(),
            type_name: data.type_name(),
            qos: data.qos(),
            user_data: &reader.user_data,
        }
    }

    fn endpoint(&self, node: Option<String>, partitions: Vec<String>) -> Endpoint {
        Endpoint {
            id: data_encoding::HEXLOWER.encode(&self.guid.to_bytes()),
            kind: self.kind,
            node,
            topic: names::topic_to_ros(self.topic).to_owned(),
            type_name: Topic::ros_type(self.type_name),
            type_hash: names::type_hash(self.user_data).map(str::to_owned),
            qos: Some(Qos { partitions, ..qos::from_policies(&self.qos, self.kind) }),
            is_matched_by_qos: true,
        }
    }
}

/// The known endpoints and participants. Methods return an error if there are too many.
pub(crate) struct Endpoints {
    own: Prefix,
    known: HashMap<GUID, Endpoint>,
    /// The participants with their names.
    participants: HashMap<Prefix, Option<String>>,
    partitions: Partitions,
}

impl Endpoints {
    /// Creates an empty set. Endpoints of the participant `own` will be skipped.
    pub(crate) fn new(own: GUID, partitions: Partitions) -> Self {
        Self { own: prefix(own), known: HashMap::new(), participants: HashMap::new(), partitions }
    }

    /// True if an endpoint belongs to this program.
    pub(crate) fn is_own(&self, guid: GUID) -> bool {
        prefix(guid) == self.own
    }

    /// The endpoint with a GUID.
    pub(crate) fn get(&self, guid: GUID) -> Option<&Endpoint> {
        self.known.get(&guid)
    }

    /// True if a publisher of this topic and type stores messages for new subscribers.
    pub(crate) fn stores(&self, topic: &str, type_name: &str) -> bool {
        let is_match = |endpoint: &Endpoint| endpoint.topic == topic && endpoint.type_name == type_name;
        self.known.values().any(|endpoint| is_match(endpoint) && stores(endpoint))
    }

    /// Adds an endpoint, and reports it if it is new or has changed.
    pub(crate) fn add(&mut self, found: &Found<'_>, events: &mut Vec<Event>) -> Result<(), String> {
        if self.is_own(found.guid) || found.topic.starts_with(BUILT_IN) {
            return Ok(());
        }
        if found.topic.len() > MAX_NAME || found.type_name.len() > MAX_NAME {
            let text = format!("participant {}: a name of more than {MAX_NAME} bytes", self.name(found.guid));
            events.push(Event::Problem(text));
            return Ok(());
        }
        let participant = prefix(found.guid);
        if !self.known.contains_key(&found.guid) {
            self.read_partitions();
        }
        let partitions = self.partitions.of(&found.guid.to_bytes());
        let endpoint = found.endpoint(self.participants.get(&participant).cloned().flatten(), partitions);
        if self.known.get(&found.guid) == Some(&endpoint) {
            return Ok(());
        }
        events.push(Event::Endpoint(endpoint.clone()));
        self.known.insert(found.guid, endpoint);
        limit(self.known.len(), "endpoints")
    }

    /// Reads new announcements of partitions.
    pub(crate) fn read_partitions(&mut self) {
        let known = &self.known;
        self.partitions.read(|guid| known.contains_key(&GUID::from_bytes(*guid)));
    }

    /// The name of a participant, or its GUID.
    fn name(&self, guid: GUID) -> String {
        let prefix = prefix(guid);
        let name = self.participants.get(&prefix).cloned().flatten();
        name.map_or_else(|| data_encoding::HEXLOWER.encode(&prefix), |name| name.escape_debug().to_string())
    }

    /// Removes an endpoint.
    pub(crate) fn remove(&mut self, guid: GUID, events: &mut Vec<Event>) {
        events.extend(self.known.remove(&guid).map(|endpoint| Event::Ended(endpoint.id)));
    }

    /// Removes a participant with its endpoints.
    pub(crate) fn remove_participant(&mut self, participant: Prefix, events: &mut Vec<Event>) {
        self.participants.remove(&participant);
        self.remove_all(|guid| prefix(guid) == participant, events);
    }

    /// Removes the endpoints that meet a condition.
    pub(crate) fn remove_all(&mut self, is_removed: impl Fn(GUID) -> bool, events: &mut Vec<Event>) {
        let removed = self.known.extract_if(|guid, _| is_removed(*guid));
        events.extend(removed.map(|(_, endpoint)| Event::Ended(endpoint.id)));
    }

    /// Adds a participant. If its name has changed, reports its endpoints.
    pub(crate) fn add_participant(
        &mut self,
        guid: GUID,
        name: Option<&str>,
        events: &mut Vec<Event>,
    ) -> Result<(), String> {
        let (participant, name) = (prefix(guid), name.and_then(names::node).map(str::to_owned));
        let before = self.participants.insert(participant, name.clone()).flatten();
        if before != name {
            for (_, endpoint) in self.known.iter_mut().filter(|(guid, _)| prefix(**guid) == participant) {
                endpoint.node.clone_from(&name);
                events.push(Event::Endpoint(endpoint.clone()));
            }
        }
        limit(self.participants.len(), "participants")
    }
}

/// True if an endpoint is a publisher that stores messages for new subscribers.
pub(crate) fn stores(endpoint: &Endpoint) -> bool {
    let stores =
        |qos: &Qos| qos.reliability == Reliability::Reliable && qos.durability != Durability::Volatile;
    endpoint.kind == EndpointKind::Publisher && endpoint.qos.as_ref().is_some_and(stores)
}

/// Fails if there are too many of `things`.
pub(crate) fn limit(count: usize, things: &str) -> Result<(), String> {
    if count <= MAX_ENDPOINTS {
        return Ok(());
    }
    Err(format!("the domain has more than {MAX_ENDPOINTS} {things}"))
}
