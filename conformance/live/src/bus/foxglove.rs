//! A client of Foxglove's WebSocket protocol, as in `foxglove_bridge` and the Foxglove SDK.
//!
//! The protocol announces neither the quality of service nor the nodes.

mod channel;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;
use std::time::Instant;

use serde_json::json;
use tungstenite::Message;
use uavspec_model::Qos;
use uavspec_model::clock::Clock;
use uavspec_model::json::Tree;
use uavspec_model::net::Address;

use self::channel::Channel;
use super::websocket::{
    CONNECT_LIMIT, Link, Protocol, Service, check_name, excerpt, list, receive, step, string,
};
use super::{Bus, Event, MAX_ENDPOINTS, Publisher, Received, Topic, nanoseconds};
use crate::limits::{MAX_MESSAGE, MAX_SCHEMAS};

/// The opcode of binary messages that contain a topic's message, in both directions.
const MESSAGE_DATA: u8 = 1;

/// The opcodes of other binary messages: times, responses of services, assets, and the playback state.
const OTHER_KINDS: std::ops::RangeInclusive<u8> = 2..=5;

/// A part of the status text that `foxglove_bridge` sends if it drops messages. The text doesn't name their topics.
const DROPPED: &str = "buffer limit";

const NO_PUBLISHING: &str = "clients can't publish: add `clientPublish` to the server's capabilities, for example in the \
                             parameter `capabilities` of foxglove_bridge";

/// The server to connect to. The client doesn't offer `foxglove.sdk.v1.1`, which moves schemas to a table. Servers
/// still support the previous version.
const SERVICE: Service = Service {
    example: "foxglove_bridge (port 8765)",
    subprotocols: "foxglove.sdk.v1, foxglove.websocket.v1",
};

/// A connection to a Foxglove server.
pub(super) struct Foxglove {
    link: Link,
    /// `Ok` if clients can publish. The error is the reason why they can't. `None` until the server has described
    /// itself.
    publishing: Option<Result<(), &'static str>>,
    channels: HashMap<u64, Channel>,
    /// The topics to receive. Some may not have a channel yet.
    wanted: HashSet<Arc<str>>,
    /// The channel of each subscription.
    subscriptions: HashMap<u32, u64>,
    /// The number of the last subscription.
    last: u32,
    /// The number of publishers. They are numbered, starting with 1.
    publishers: usize,
    /// The size of the schemas of all channels, in bytes.
    schemas: usize,
}

impl Foxglove {
    /// Connects, and waits until the server has described itself. The error describes the problem.
    pub(super) fn connect(address: &Address) -> Result<Self, String> {
        let until = Clock::real().now() + CONNECT_LIMIT;
        Self::greet(Link::open(&SERVICE, address, until)?, until)
    }

    /// Waits for the information that a server sends first.
    fn greet(link: Link, until: Instant) -> Result<Self, String> {
        let mut client = Self {
            link,
            publishing: None,
            channels: HashMap::new(),
            wanted: HashSet::new(),
            subscriptions: HashMap::new(),
            last: 0,
            publishers: 0,
            schemas: 0,
        };
        while client.publishing.is_none() {
            if !step(&mut client, until) && client.publishing.is_none() {
                let none = || "expected `serverInfo` from a Foxglove server, found none in time".to_owned();
                return Err(client.link.closed().unwrap_or_else(none));
            }
        }
        Ok(client)
    }

    fn server_info(&mut self, info: &Tree<'_>) -> Result<(), String> {
        let contain = |names: &[Tree<'_>], name: &str| names.iter().any(|known| known.as_str() == Some(name));
        let encodings = list(info, "supportedEncodings");
        self.publishing = Some(if !contain(list(info, "capabilities")?, "clientPublish") {
            Err(NO_PUBLISHING)
        } else if encodings.is_ok_and(|names| !contain(names, "cdr")) {
            Err("clients can't publish CDR: the server supports only other encodings")
        } else {
            Ok(())
        });
        Ok(())
    }

    fn advertised(&mut self, channels: &[Tree<'_>]) -> Result<(), String> {
        // A set, because a message may contain a channel twice.
        let mut wanted = BTreeSet::new();
        for channel in channels {
            match self.add(channel) {
                Ok(id) => wanted.extend(id.filter(|id| self.is_wanted(*id))),
                Err(problem) => self.link.problem(format!("ignored a channel: {problem}")),
            }
        }
        self.subscribe_channels(&wanted)
    }

    /// Adds or replaces a channel. Returns its id, or `None` if there are too many channels.
    fn add(&mut self, described: &Tree<'_>) -> Result<Option<u64>, String> {
        let (id, mut channel) = Channel::read(described)?;
        self.remove(id);
        if self.channels.len() >= MAX_ENDPOINTS {
            self.link.unreadable(format!(
                "ignored the channels after the first {MAX_ENDPOINTS}: limit the topics of the server, for example \
                 with the parameter `topic_whitelist` of foxglove_bridge"
            ));
            return Ok(None);
        }
        let total = self.schemas + channel.schema_size();
        if total > MAX_SCHEMAS {
            channel.refuse(format!("expected at most {MAX_SCHEMAS} bytes of schemas, found {total} bytes"));
        }
        self.schemas += channel.schema_size();
        self.link.push(channel.endpoint(id));
        self.channels.insert(id, channel);
        Ok(Some(id))
    }

    fn unadvertised(&mut self, ids: &[Tree<'_>]) {
        for id in ids {
            match channel::id(id) {
                Some(id) => self.remove(id),
                None => self.link.problem(format!("expected the id of a channel, found {id}")),
            }
        }
    }

    fn remove(&mut self, id: u64) {
        let Some(channel) = self.channels.remove(&id) else { return };
        self.schemas -= channel.schema_size();
        if let Some(subscription) = channel.subscription {
            self.subscriptions.remove(&subscription);
        }
        self.link.push(Event::Ended(channel::endpoint_id(id)));
    }

    fn is_wanted(&self, id: u64) -> bool {
        self.channels.get(&id).is_some_and(|channel| self.wanted.contains(&channel.topic.name))
    }

    /// Subscribes to channels that have no subscription yet.
    fn subscribe_channels(&mut self, ids: &BTreeSet<u64>) -> Result<(), String> {
        let mut subscriptions = Vec::new();
        for &id in ids {
            match self.new_subscription(id) {
                Ok(number) => subscriptions.push(json!({ "id": number, "channelId": id })),
                Err(problem) => self.link.unreadable(problem),
            }
        }
        if subscriptions.is_empty() {
            return Ok(());
        }
        self.link.request(&json!({ "op": "subscribe", "subscriptions": subscriptions }))
    }

    /// Returns the number of a new subscription. The error is the reason why the channel can't be read.
    fn new_subscription(&mut self, id: u64) -> Result<u32, String> {
        let channel = self.channels.get_mut(&id).ok_or_else(|| format!("channel {id} ended"))?;
        if let Err(problem) = &channel.encoding {
            return Err(format!("can't read {:?} (channel {id}): {problem}", channel.topic.name));
        }
        self.last = self.last.checked_add(1).ok_or("the server has advertised too many channels")?;
        channel.subscription = Some(self.last);
        self.subscriptions.insert(self.last, id);
        Ok(self.last)
    }

    /// Reads a message of a topic: the number of the subscription, the time of the server, and the payload.
    fn message(&mut self, bytes: &[u8]) -> Result<(), String> {
        let short = || format!("received a message of {} bytes: expected at least 13", bytes.len() + 1);
        let (number, rest) = bytes.split_first_chunk().ok_or_else(short)?;
        let (_, payload) = rest.split_first_chunk::<8>().ok_or_else(short)?;
        let number = u32::from_le_bytes(*number);
        let id = self.subscriptions.get(&number);
        let Some(channel) = id.and_then(|id| self.channels.get(id)) else {
            // Messages may still arrive after their channel has ended.
            let is_old = (1..=self.last).contains(&number);
            return if is_old {
                Ok(())
            } else {
                Err(format!("received a message for the unknown subscription {number}"))
            };
        };
        let (topic, schema) = (channel.topic.clone(), channel.schema.clone());
        let (time, encoding) = (nanoseconds(&Clock::real()), channel.encoding.clone()?);
        let message = Received::new(topic, encoding, time, payload.to_vec());
        self.link.push(Event::Message(Received { schema, ..message }));
        Ok(())
    }

    /// Reports a status message of the server.
    fn status(&mut self, status: &Tree<'_>) -> Result<(), String> {
        let message = excerpt(string(status, "message")?);
        if message.to_ascii_lowercase().contains(DROPPED) {
            self.link.unreadable(format!("the server dropped messages: {message:?}"));
            return Ok(());
        }
        match status.get("level") {
            Some(Tree::Int(0)) => {}
            Some(Tree::Int(1)) => self.link.problem(format!("the server reports a warning: {message:?}")),
            _ => self.link.problem(format!("the server reports an error: {message:?}")),
        }
        Ok(())
    }
}

impl Protocol for Foxglove {
    fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    fn text(&mut self, text: &str) -> Result<(), String> {
        let operation = Tree::read(text).map_err(|error| error.to_string())?;
        match string(&operation, "op")? {
            "serverInfo" => self.server_info(&operation),
            "advertise" => self.advertised(list(&operation, "channels")?),
            "unadvertise" => {
                self.unadvertised(list(&operation, "channelIds")?);
                Ok(())
            }
            "status" => self.status(&operation),
            _ => Ok(()),
        }
    }

    fn binary(&mut self, bytes: &[u8]) -> Result<(), String> {
        match bytes.split_first() {
            Some((&MESSAGE_DATA, rest)) => self.message(rest),
            Some((kind, _)) if OTHER_KINDS.contains(kind) => Ok(()),
            Some((kind, _)) => {
                self.link.problem(format!("received a binary message of unknown kind {kind}"));
                Ok(())
            }
            None => Err("received an empty binary message".to_owned()),
        }
    }
}

impl Bus for Foxglove {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        receive(self, deadline)
    }

    /// Subscribes to a topic. The server chooses the quality of service.
    fn subscribe(&mut self, topic: &Topic, _: &Qos) -> Result<(), String> {
        check_name("topic", &topic.name)?;
        if self.wanted.len() >= MAX_ENDPOINTS {
            return Err(format!("expected at most {MAX_ENDPOINTS} subscriptions"));
        }
        if !self.wanted.insert(Arc::clone(&topic.name)) {
            return Ok(());
        }
        let channels = self.channels.iter().filter(|(_, channel)| channel.topic.name == topic.name);
        let ids = channels.map(|(id, _)| *id).collect();
        self.subscribe_channels(&ids)
    }

    /// Advertises a topic. The server chooses the quality of service.
    fn advertise(&mut self, topic: &Topic, _: &Qos) -> Result<Publisher, String> {
        check_name("topic", &topic.name)?;
        if let Some(Err(reason)) = self.publishing {
            return Err(reason.to_owned());
        }
        if self.publishers >= MAX_ENDPOINTS {
            return Err(format!("expected at most {MAX_ENDPOINTS} publishers"));
        }
        let id = self.publishers + 1;
        let channel =
            json!({ "id": id, "topic": &*topic.name, "encoding": "cdr", "schemaName": &*topic.type_name });
        self.link.request(&json!({ "op": "advertise", "channels": [channel] }))?;
        self.publishers = id;
        Ok(Publisher(id))
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        let id = u32::try_from(publisher.0).ok().filter(|_| (1..=self.publishers).contains(&publisher.0));
        let id = id.ok_or("an unknown publisher")?;
        if payload.len() > MAX_MESSAGE {
            return Err(format!(
                "expected a message of at most {MAX_MESSAGE} bytes, found {}",
                payload.len()
            ));
        }
        let message = [&[MESSAGE_DATA], &id.to_le_bytes()[..], payload].concat();
        self.link.send(Message::binary(message))
    }
}

#[cfg(test)]
mod tests;
