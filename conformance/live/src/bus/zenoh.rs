//! A Zenoh network, with the key names that ROS 2's `rmw_zenoh` uses.
//!
//! - A liveliness token announces an endpoint, see [`token`]. Nodes and services aren't reported.
//! - A message is a sample with an attachment. The sequence numbers in attachments reveal losses, see [`sequence`].
//! - Transient local publishers store messages, and reply with them to queries for keys below the key of their topic.
//!   The caches of early `rmw_zenoh` versions used other keys, and aren't queried.
//! - Zenoh drops a sample of more than 64 MiB without notice. The next message of the same publisher reveals the gap.
//! - Zenoh delivers large numbers of tokens slowly: 12,000 tokens take about 11 seconds.
//!
//! The crate hiroz-protocol has similar code, but it requires the default features of zenoh, and reads hashes that it
//! can't parse as zeros.

mod attachment;
mod error;
mod graph;
mod intake;
mod keys;
mod publication;
mod qos;
mod sequence;
#[cfg(test)]
mod tests;
mod token;

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;
use uavspec_model::net::Address;
use uavspec_model::{Durability, Endpoint, EndpointKind, Qos};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, QueryTarget, Reply, ReplyKeyExpr};
use zenoh::sample::{Locality, SampleKind};
use zenoh::{Config, Session, Wait};

use self::error::{failure, reason};
use self::graph::Graph;
use self::intake::Intake;
use self::publication::Publication;
use self::sequence::Delivery;
use self::token::Token;
use super::queue::{Queue, Sender, queue};
use super::{Bus, Event, Publisher, Topic};

/// The name of the node of this program.
const NODE: &str = "/uavspec";
/// The maximum size of a message, in bytes.
const MAX_SIZE: usize = 64 << 20;
/// The maximum number of queries that wait for replies.
const MAX_QUERIES: usize = 256;
/// The time within which a router must accept the connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);
/// The time within which publishers must reply to a query for stored messages.
const QUERY_TIMEOUT: Duration = Duration::from_secs(3);
/// The time between two checks of the connection.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// A session on a Zenoh network.
pub(super) struct Zenoh {
    // Must be the first field: once the queue is dropped, no thread of Zenoh waits for space in it, and the session can
    // close.
    queue: Queue,
    sender: Sender,
    domain: u16,
    graph: Graph,
    /// Problems that this thread has found. This thread can't add them to the queue, because it would wait for itself.
    problems: VecDeque<Event>,
    subscriptions: HashMap<Arc<str>, Subscription>,
    publications: Vec<Publication>,
    last_id: u64,
    /// The topics whose stored messages haven't been queried yet.
    unqueried: BTreeSet<Arc<str>>,
    /// Shared with the queries that wait for replies: the number of clones is their number.
    queries: Arc<()>,
    checked: Instant,
    is_closed: bool,
    _tokens: Subscriber<()>,
    _node: LivelinessToken,
    session: Session,
}

/// A subscribed topic.
struct Subscription {
    topic: Topic,
    key: String,
    intake: Arc<Intake>,
    _subscriber: Subscriber<()>,
    _token: LivelinessToken,
}

/// A query for stored messages.
struct Query {
    intake: Arc<Intake>,
    _count: Arc<()>,
}

impl Query {
    fn accept(&self, reply: &Reply) {
        if let Ok(sample) = reply.result() {
            self.intake.accept(sample, Delivery::Stored);
        }
    }
}

impl Zenoh {
    /// Connects to a router or a peer.
    pub(super) fn connect(address: &Address, domain: u16) -> Result<Self, String> {
        let session = open(address)?;
        let (sender, queue) = queue();
        let node =
            declare_token(&session, &token::node_token(domain, &session.zid().to_string(), &NODE[1..]))?;
        let tokens = subscribe_to_tokens(&session, domain, &sender)?;
        Ok(Self {
            queue,
            sender,
            domain,
            graph: Graph::default(),
            problems: VecDeque::new(),
            subscriptions: HashMap::new(),
            publications: Vec::new(),
            last_id: 0,
            unqueried: BTreeSet::new(),
            queries: Arc::default(),
            checked: Clock::real().now(),
            is_closed: false,
            _tokens: tokens,
            _node: node,
            session,
        })
    }

    /// Returns the token and the number of the next endpoint of this program.
    fn next_token(&mut self, kind: EndpointKind, topic: &Topic, qos: &Qos) -> (u64, String) {
        self.last_id += 1;
        let (session, node) = (self.session.zid().to_string(), NODE.to_owned());
        let token = Token { session, kind, node, topic: topic.clone(), qos: qos.clone() };
        (self.last_id, token.format(self.domain, self.last_id))
    }

    /// Queries stored messages. If too many queries are waiting for replies, the other topics are queried later.
    fn query_stored(&mut self) {
        while Arc::strong_count(&self.queries) <= MAX_QUERIES
            && let Some(name) = self.unqueried.pop_first()
            && let Some(subscription) = self.subscriptions.get(&name)
        {
            let intake = Arc::clone(&subscription.intake);
            let waiting = Query { intake, _count: Arc::clone(&self.queries) };
            let selector = format!("{}/@adv/**", subscription.key);
            let query = self.session.get(&selector).target(QueryTarget::All).timeout(QUERY_TIMEOUT);
            let query = query.consolidation(ConsolidationMode::None).accept_replies(ReplyKeyExpr::Any);
            let query = query.allowed_destination(Locality::Remote);
            if let Err(error) = query.callback(move |reply| waiting.accept(&reply)).wait() {
                self.problems.push_back(Event::Unreadable(failure("query", &selector, &error)));
            }
        }
    }

    /// Handles an event about an endpoint whose topic this program uses.
    fn follow(&mut self, event: &Event) {
        let Event::Endpoint(endpoint) = event else { return };
        match endpoint.kind {
            EndpointKind::Publisher => {
                let stores = endpoint.qos.as_ref().is_some_and(|qos| qos.durability != Durability::Volatile);
                if stores && let Some((name, _)) = self.subscriptions.get_key_value(&*endpoint.topic) {
                    self.unqueried.insert(Arc::clone(name));
                }
            }
            EndpointKind::Subscriber => self.problems.extend(self.mismatch(endpoint).map(Event::Problem)),
        }
    }

    /// The problem to report if a subscriber expects another type, so that it doesn't receive this program's messages.
    fn mismatch(&self, subscriber: &Endpoint) -> Option<String> {
        let (type_name, hash) = (&*subscriber.type_name, subscriber.type_hash.as_deref());
        if type_name.is_empty() {
            // The type is unknown.
            return None;
        }
        let mut topics = self.publications.iter().map(|publication| &publication.topic);
        let topic = topics.find(|topic| {
            *topic.name == *subscriber.topic
                && (&*topic.type_name, topic.type_hash.as_deref()) != (type_name, hash)
        })?;
        let node = subscriber.node.as_deref().unwrap_or_default();
        Some(format!(
            "{}: {} expects {}, so it doesn't receive the published {}",
            topic.name.escape_debug(),
            node.escape_debug(),
            shown(type_name, hash),
            shown(&topic.type_name, topic.type_hash.as_deref())
        ))
    }

    /// The event for the end of the connection, if it has ended. Zenoh reconnects, but the program would miss messages
    /// without notice.
    fn check_connection(&mut self) -> Option<Event> {
        if Clock::real().now() < self.checked + CHECK_PERIOD {
            return None;
        }
        self.checked = Clock::real().now();
        let info = self.session.info();
        self.is_closed =
            info.routers_zid().wait().next().is_none() && info.peers_zid().wait().next().is_none();
        self.is_closed
            .then(|| Event::Closed("the router closed the connection, or stopped responding".to_owned()))
    }
}

impl Bus for Zenoh {
    fn receive(&mut self, deadline: Instant) -> Option<Event> {
        while !self.is_closed {
            self.query_stored();
            if let Some(problem) = self.problems.pop_front() {
                return Some(problem);
            }
            let event = self.queue.receive(deadline.min(self.checked + CHECK_PERIOD));
            let event = match event {
                Some(event) => self.graph.follow(event),
                None => self.check_connection(),
            };
            if let Some(event) = event {
                self.follow(&event);
                return Some(event);
            }
            if Clock::real().now() >= deadline {
                return None;
            }
        }
        None
    }

    fn subscribe(&mut self, topic: &Topic, qos: &Qos) -> Result<(), String> {
        if let Some(subscription) = self.subscriptions.get(&topic.name) {
            self.problems.extend(subscription.other_type(topic).map(Event::Unreadable));
            return Ok(());
        }
        let key = keys::subscription_key(self.domain, topic)?;
        let intake = Arc::new(Intake::new(topic.clone(), self.sender.clone()));
        let target = Arc::clone(&intake);
        let subscriber = self.session.declare_subscriber(&key).allowed_origin(Locality::Remote);
        let subscriber = subscriber.callback(move |sample| target.accept(&sample, Delivery::Live));
        let subscriber = subscriber.wait().map_err(|error| failure("subscribe to", &key, &error))?;
        let (_, token) = self.next_token(EndpointKind::Subscriber, topic, qos);
        let token = declare_token(&self.session, &token)?;
        let topic = topic.clone();
        self.unqueried.insert(Arc::clone(&topic.name));
        let name = Arc::clone(&topic.name);
        let subscription = Subscription { topic, key, intake, _subscriber: subscriber, _token: token };
        self.subscriptions.insert(name, subscription);
        Ok(())
    }

    fn advertise(&mut self, topic: &Topic, qos: &Qos) -> Result<Publisher, String> {
        let mut topic = topic.clone();
        if topic.type_hash.is_none() {
            topic.type_hash = self.graph.hash(&topic).map(Into::into);
        }
        let key = keys::publication_key(self.domain, &topic)?;
        let (number, token) = self.next_token(EndpointKind::Publisher, &topic, qos);
        let publication = Publication::declare(&self.session, &key, topic, (number, &token), qos)?;
        self.publications.push(publication);
        Ok(Publisher(self.publications.len() - 1))
    }

    fn publish(&mut self, publisher: Publisher, payload: &[u8]) -> Result<(), String> {
        let publication = self.publications.get_mut(publisher.0);
        publication.ok_or_else(|| format!("found no publisher {}", publisher.0))?.publish(payload)
    }

    fn remaining_losses(&mut self) -> Vec<Event> {
        self.queue.remaining_losses()
    }
}

impl Subscription {
    /// The problem to report if this subscription has another type, so that it ignores messages of the topic `other`.
    fn other_type(&self, other: &Topic) -> Option<String> {
        let Topic { name, type_name, type_hash } = &self.topic;
        let is_included =
            *type_name == other.type_name && (type_hash.is_none() || *type_hash == other.type_hash);
        let shown = |topic: &Topic| shown(&topic.type_name, topic.type_hash.as_deref());
        let text = || {
            let (name, other, received) = (name.escape_debug(), shown(other), shown(&self.topic));
            format!("{name}: ignored messages of {other}, because messages of {received} are received")
        };
        (!is_included).then(text)
    }
}

/// The text for a type and its hash in problems.
fn shown(type_name: &str, hash: Option<&str>) -> String {
    format!("{} with the hash {}", type_name.escape_debug(), hash.unwrap_or("-").escape_debug())
}

/// Opens a session that connects to an address, and uses neither other connections nor multicast.
fn open(address: &Address) -> Result<Session, String> {
    let host = &address.host;
    // Zenoh's addresses may contain options.
    if !host.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-._:".contains(&byte)) {
        return Err(format!("expected a host name or an IP address, found `{}`", host.escape_debug()));
    }
    let timeout = CONNECT_TIMEOUT.as_millis().to_string();
    let settings = [
        ("mode", "\"client\""),
        ("connect/endpoints", &format!("[\"tcp/{address}\"]")),
        ("connect/timeout_ms", &timeout),
        ("connect/exit_on_failure", "true"),
        ("transport/unicast/open_timeout", &timeout),
        ("listen/endpoints", "[]"),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        ("transport/link/rx/max_message_size", &MAX_SIZE.to_string()),
    ];
    let mut config = Config::default();
    for (key, value) in settings {
        config.insert_json5(key, value).map_err(|error| failure("set", key, &error))?;
    }
    zenoh::open(config).wait().map_err(|error| {
        let (seconds, reason) = (CONNECT_TIMEOUT.as_secs(), reason(&error));
        format!(
            "no connection to a Zenoh router at {address} within {seconds} s: {reason}; \
             start a router such as rmw_zenohd, or correct the address"
        )
    })
}

fn declare_token(session: &Session, key: &str) -> Result<LivelinessToken, String> {
    session.liveliness().declare_token(key).wait().map_err(|error| failure("announce", key, &error))
}

/// Subscribes to tokens, and adds the endpoints of others to the queue.
fn subscribe_to_tokens(session: &Session, domain: u16, sender: &Sender) -> Result<Subscriber<()>, String> {
    let (key, own, sender) = (token::all_tokens(domain), session.zid().to_string(), sender.clone());
    let tokens = session.liveliness().declare_subscriber(&key).history(true);
    let tokens = tokens.callback(move |sample| {
        let key = sample.key_expr().as_str();
        let event = match sample.kind() {
            SampleKind::Put => graph::appeared(key, &own),
            SampleKind::Delete => Some(Event::Ended(key.to_owned())),
        };
        if let Some(event) = event {
            sender.send(event);
        }
    });
    tokens.wait().map_err(|error| failure("subscribe to", &key, &error))
}
