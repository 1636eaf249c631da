//! The publishers of this program.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use uavspec_model::clock::Clock;
use uavspec_model::{Durability, History, Qos, Reliability};
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::sample::Locality;
use zenoh::time::Timestamp;
use zenoh::{Session, Wait, pubsub};

use super::attachment::Attachment;
use super::error::failure;
use crate::bus::{Topic, nanoseconds};

/// The maximum number of messages that a transient local publisher stores.
const MAX_STORED: usize = 64;

/// A publisher.
pub(super) struct Publication {
    pub(super) topic: Topic,
    publisher: pubsub::Publisher<'static>,
    id: [u8; 16],
    sequence: i64,
    store: Option<Store>,
    session: Session,
    _token: LivelinessToken,
}

/// The messages that a transient local publisher stores for later subscribers. The format is the same as in zenoh-ext's
/// `AdvancedPublisher`, which `rmw_zenoh` uses.
struct Store {
    messages: Arc<Mutex<VecDeque<Stored>>>,
    depth: usize,
    _queryable: Queryable<()>,
    _token: LivelinessToken,
}

/// A stored message.
struct Stored {
    payload: Vec<u8>,
    attachment: Vec<u8>,
    /// The timestamp by which a subscriber recognizes a message that arrives twice.
    time: Timestamp,
}

impl Publication {
    /// Declares a publisher. `number` is its number in the session, and `token` its liveliness token.
    pub(super) fn declare(
        session: &Session,
        key: &str,
        topic: Topic,
        (number, token): (u64, &str),
        qos: &Qos,
    ) -> Result<Self, String> {
        // As in rmw_zenoh, a publisher waits for its subscribers only if its messages must not be lost.
        let waits = qos.reliability == Reliability::Reliable && qos.history == Some(History::KeepAll);
        let congestion = if waits { CongestionControl::Block } else { CongestionControl::Drop };
        let store = match qos.durability {
            Durability::Volatile => None,
            _ => Some(Store::declare(session, key, number, qos.history)?),
        };
        let publisher = session.declare_publisher(key.to_owned()).congestion_control(congestion);
        let publisher = publisher.allowed_destination(Locality::Remote);
        let publisher = publisher.wait().map_err(|error| failure("publish on", key, &error))?;
        let id = publisher_id(session, number);
        let token = session.liveliness().declare_token(token.to_owned()).wait();
        let token = token.map_err(|error| failure("announce", key, &error))?;
        Ok(Self { topic, publisher, id, sequence: 0, store, session: session.clone(), _token: token })
    }

    /// Publishes a message.
    pub(super) fn publish(&mut self, payload: &[u8]) -> Result<(), String> {
        let stamp = self.session.new_timestamp();
        self.sequence = self.sequence.wrapping_add(1);
        let time = i64::try_from(nanoseconds(&Clock::real())).unwrap_or(i64::MAX);
        let attachment = Attachment { sequence: self.sequence, time, publisher: self.id }.format();
        if let Some(store) = &self.store {
            store.add(Stored { payload: payload.to_vec(), attachment: attachment.clone(), time: stamp });
        }
        let put = self.publisher.put(payload).attachment(attachment).timestamp(stamp).wait();
        put.map_err(|error| failure("publish on", self.publisher.key_expr().as_str(), &error))
    }
}

impl Store {
    fn declare(
        session: &Session,
        topic: &str,
        number: u64,
        history: Option<History>,
    ) -> Result<Self, String> {
        let depth = match history {
            None => 1,
            Some(History::KeepLast(depth)) => {
                usize::try_from(depth).unwrap_or(MAX_STORED).clamp(1, MAX_STORED)
            }
            Some(History::KeepAll) => MAX_STORED,
        };
        let key = format!("{topic}/@adv/pub/{}/{number}/_", session.zid());
        let messages: Arc<Mutex<VecDeque<Stored>>> = Arc::default();
        let (answers, name) = (Arc::clone(&messages), topic.to_owned());
        let queryable = session.declare_queryable(&key).allowed_origin(Locality::Remote);
        let queryable = queryable.callback(move |query| answer(&query, &name, &locked(&answers)));
        let queryable = queryable.wait().map_err(|error| failure("store messages of", &key, &error))?;
        let token = session.liveliness().declare_token(&key).wait();
        let token = token.map_err(|error| failure("announce", &key, &error))?;
        Ok(Self { messages, depth, _queryable: queryable, _token: token })
    }

    fn add(&self, message: Stored) {
        let mut messages = locked(&self.messages);
        if messages.len() >= self.depth {
            messages.pop_front();
        }
        messages.push_back(message);
    }
}

fn locked(messages: &Mutex<VecDeque<Stored>>) -> MutexGuard<'_, VecDeque<Stored>> {
    messages.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Replies to a query for stored messages. If the other end is no longer waiting, the error is ignored.
fn answer(query: &Query, topic: &str, messages: &VecDeque<Stored>) {
    let limit = query.parameters().get("_max").and_then(|max| max.parse().ok()).unwrap_or(usize::MAX);
    for message in messages.iter().skip(messages.len().saturating_sub(limit)) {
        let reply = query.reply(topic, &message.payload).attachment(&message.attachment);
        if reply.timestamp(message.time).wait().is_err() {
            return;
        }
    }
}

/// The identifier of a publisher in attachments: 12 bytes from the session, and 4 bytes from its number.
fn publisher_id(session: &Session, number: u64) -> [u8; 16] {
    let mut id = session.zid().to_le_bytes();
    let (_, tail) = id.split_at_mut(12);
    tail.copy_from_slice(&number.to_le_bytes()[..4]);
    id
}
