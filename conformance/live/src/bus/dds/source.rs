//! Subscribed topics.

use std::collections::HashMap;
use std::sync::Arc;

use rustdds::mio1::{Interest, Registry, Token};
use rustdds::no_key::DeserializedCacheChange;
use rustdds::{GUID, Timestamp};
use uavspec_model::{Qos, Reliability};

use super::super::queue::Sender;
use super::super::{Encoding, Event, MAX_ENDPOINTS, Received, Topic};
use super::endpoints::Endpoints;
use super::reader::{RawReader, Readers};

/// The maximum number of messages that are read from a topic before the next topic is read.
const BATCH: usize = 64;

/// The maximum distance between the sequence numbers of a late message and the latest one. A greater distance means
/// that the publisher's numbering has restarted.
const MAX_LATENESS: u64 = 1_000;

/// A subscribed topic.
pub(crate) struct Source {
    pub(crate) topic: Topic,
    token: Token,
    reader: RawReader,
    /// A subscriber that requests stored messages. Its messages are also returned by `reader`, because all subscribers
    /// of a topic share a cache.
    stored: Option<RawReader>,
    /// True if publishers may send missing messages again.
    is_reliable: bool,
    publishers: HashMap<GUID, Publisher>,
    /// True if there may be messages to read.
    pub(crate) has_more: bool,
}

/// The state of a publisher.
struct Publisher {
    topic: Topic,
    /// The highest sequence number.
    last: i64,
    /// The number of lower sequence numbers that are missing.
    missing: u64,
    /// The number of sequence numbers that were missing at the last call of `report_missing`.
    overdue: u64,
}

impl Source {
    pub(crate) fn create(
        topic: Topic,
        qos: &Qos,
        readers: &Readers,
        registry: &Registry,
        token: Token,
    ) -> Result<Self, String> {
        let mut reader = readers.create(&topic, qos)?;
        register(&mut reader, registry, token)?;
        let (is_reliable, publishers) = (qos.reliability == Reliability::Reliable, HashMap::new());
        Ok(Self { topic, token, reader, stored: None, is_reliable, publishers, has_more: true })
    }

    /// Requests the messages that publishers store. Does nothing if they have already been requested.
    pub(crate) fn request_stored(&mut self, readers: &Readers, registry: &Registry) -> Result<(), String> {
        if self.stored.is_none() {
            let qos = Qos { reliability: Reliability::Reliable, ..Qos::PX4 };
            let mut reader = readers.create(&self.topic, &qos)?;
            register(&mut reader, registry, self.token)?;
            self.stored = Some(reader);
            self.is_reliable = true;
        }
        Ok(())
    }

    /// Resets rustdds's notifications of new messages. Must be called before the messages are read.
    pub(crate) fn notice(&mut self) {
        for reader in [Some(&self.reader), self.stored.as_ref()].into_iter().flatten() {
            reader.drain_read_notifications();
        }
        self.has_more = true;
    }

    /// Reads some messages. The error describes a message that can't be read.
    pub(crate) fn read(&mut self, endpoints: &Endpoints, events: &Sender) -> Result<(), String> {
        for _ in 0..BATCH {
            match self.reader.try_take_one() {
                Ok(Some(message)) => self.accept(message, endpoints, events),
                Ok(None) => {
                    self.has_more = false;
                    break;
                }
                Err(error) => {
                    return Err(format!("{}: unreadable message: {error}", self.topic.name.escape_debug()));
                }
            }
        }
        Ok(())
    }

    fn accept(&mut self, message: DeserializedCacheChange<Vec<u8>>, endpoints: &Endpoints, events: &Sender) {
        let guid = message.writer_guid;
        if endpoints.is_own(guid) {
            return;
        }
        let (number, is_reliable) = (message.sequence_number.into(), self.is_reliable);
        let publisher = self.publisher(guid, number, endpoints);
        if !is_reliable && publisher.is_late(number) {
            // The message has already been reported as lost. ROS subscribers also ignore such messages.
            return;
        }
        publisher.count(number);
        if !is_reliable {
            publisher.report_lost(publisher.missing, events);
        }
        let topic = publisher.topic.clone();
        let time = nanoseconds(message.receive_instant);
        events.send(Event::Message(Received::new(topic, Encoding::Cdr, time, message.sample)));
    }

    /// The state of a publisher. `number` is the sequence number of its next message.
    fn publisher(&mut self, guid: GUID, number: i64, endpoints: &Endpoints) -> &mut Publisher {
        if self.publishers.len() >= MAX_ENDPOINTS {
            // Former publishers, or forged ones.
            self.publishers.retain(|guid, _| endpoints.get(*guid).is_some());
        }
        let topic = &self.topic;
        self.publishers.entry(guid).or_insert_with(|| {
            let mut topic = topic.clone();
            if let Some(endpoint) = endpoints.get(guid) {
                topic.type_name = endpoint.type_name.as_str().into();
                topic.type_hash = endpoint.type_hash.as_deref().map(Into::into);
            }
            Publisher { topic, last: number.saturating_sub(1), missing: 0, overdue: 0 }
        })
    }

    /// Reports the messages that have been missing since the last call.
    pub(crate) fn report_missing(&mut self, events: &Sender) {
        for publisher in self.publishers.values_mut() {
            let count = publisher.overdue.min(publisher.missing);
            publisher.overdue = publisher.missing - count;
            publisher.report_lost(count, events);
        }
    }
}

impl Publisher {
    /// True if this message or a later one has already arrived.
    fn is_late(&self, number: i64) -> bool {
        number <= self.last && self.last.abs_diff(number) <= MAX_LATENESS
    }

    /// Reports missing messages as lost.
    fn report_lost(&mut self, count: u64, events: &Sender) {
        if count > 0 {
            self.missing -= count;
            events.send(Event::Lost { topic: Arc::clone(&self.topic.name), count });
        }
    }

    /// Updates the counts for a message. A low sequence number belongs to a message that was missing.
    fn count(&mut self, number: i64) {
        match number.saturating_sub(self.last) {
            ..=0 => self.missing = self.missing.saturating_sub(1),
            difference => {
                self.missing = self.missing.saturating_add(difference.unsigned_abs() - 1);
                self.last = number;
            }
        }
    }
}

fn register(reader: &mut RawReader, registry: &Registry, token: Token) -> Result<(), String> {
    registry.register(reader, token, Interest::READABLE).map_err(|error| format!("can't subscribe: {error}"))
}

/// The time in ns since 1970.
fn nanoseconds(time: Timestamp) -> u64 {
    let ticks = time.to_ticks();
    let fraction = ((ticks & 0xffff_ffff) * 1_000_000_000) >> 32;
    (ticks >> 32) * 1_000_000_000 + fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    fn publisher(last: i64) -> Publisher {
        let topic = Topic { name: "/wind".into(), type_name: "sky_msgs/msg/Wind".into(), type_hash: None };
        Publisher { topic, last, missing: 0, overdue: 0 }
    }

    #[test]
    fn late_messages_differ_from_numbers_that_start_again() {
        let publisher = publisher(5_000);
        for (number, is_late) in [(5_001, false), (5_000, true), (4_990, true), (1, false), (i64::MIN, false)]
        {
            assert_eq!(publisher.is_late(number), is_late, "{number}");
        }
    }

    #[test]
    fn messages_that_arrive_late_are_not_missing() {
        let mut publisher = publisher(4);
        for (number, missing) in [(5, 0), (9, 3), (7, 2), (6, 1), (10, 1), (8, 0), (3, 0), (i64::MAX, 1)] {
            publisher.count(number);
            assert_eq!(publisher.missing.min(3), missing.max(u64::from(number == i64::MAX) * 3));
        }
    }
}
