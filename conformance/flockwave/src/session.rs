//! Tracks the state of Flockwave sessions: pending requests, used ids and running operations. Rules receive each record
//! with its context in the session ([`Exchange`]).
//!
//! Captures are rarely complete. The session therefore draws only conclusions that no missing record can contradict:
//!
//! - If the start of a connection is missing, earlier requests may be unknown.
//! - After corruption, the session forgets all pending requests and operations, since their answers may have been lost.
//! - If time goes backwards, later times are ignored.
//! - All lists of remembered entries have a size limit. Forgotten entries count as unknown, not as absent.

mod clock;
mod exchange;
mod operation;
pub mod remembered;
mod request;
mod vocabulary;

use uavspec_model::json::Tree;
use uavspec_schema::json_type;

pub use self::clock::ClockMove;
use self::clock::{Adjustments, ServerClock};
pub use self::exchange::{ConnectionId, Exchange, Reference, Role, message_excerpt, seconds};
use self::operation::Operations;
pub use self::operation::{Named, Operation, Stage};
use self::remembered::{ById, Remembered};
pub use self::request::SentRequest;
pub use self::vocabulary::{OPERATION, OPERATIONS, PARTS, parts};
use crate::body_schema::BodySchemas;
use crate::limits::{MAX_FAILURE, MAX_ID, MAX_ODD_IDS, MAX_REMEMBERED};
use crate::record::{Connection, Direction, SessionRecord};

/// The tolerance for times that go backwards, in seconds. Several threads may write a capture.
const MAX_CLOCK_JITTER: f64 = 0.5;

/// The assumed maximum transit time of a message, in seconds.
const MAX_TRANSIT_TIME: f64 = 1.0;

/// A side of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Client,
    Server,
}

/// Data from the client whose id is unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Unknown {
    /// There is no such data.
    #[default]
    Nothing,
    /// A part of a message. Other parts may follow.
    Piece,
    /// A message without a usable id, or text that can't be read.
    Message,
}

/// The state of a connection.
#[derive(Clone, Debug, Default)]
struct State {
    /// A number that distinguishes the connection from earlier connections with the same name.
    serial: u64,
    /// True if all records of the connection are known.
    is_whole: bool,
    /// The sent data whose id is unknown. A later answer may refer to it.
    unknown: Unknown,
    /// The number of messages without a readable id that a message without `refs` may still answer. Unreadable text may
    /// contain any number of messages, and a capture may lack any number. Both therefore set this number to the
    /// maximum.
    num_without_id: u64,
    /// The id of the latest request, if it has one.
    latest_request: Option<String>,
    /// The ids of the first messages whose id isn't a string, as JSON.
    odd_ids: Vec<String>,
    /// The latest time.
    latest: f64,
    /// The time of the server's latest message.
    last_received: Option<f64>,
    /// True if time went backwards.
    is_time_lost: bool,
    /// The time when the server announced the end of the connection.
    ending: Option<f64>,
    /// The server's clock.
    clock: ServerClock,
}

impl State {
    /// The state of a connection whose earlier records are unknown.
    fn partial(serial: u64) -> Self {
        Self { serial, num_without_id: u64::MAX, ..Self::default() }
    }

    /// True if a message without `refs` may be an answer. Datagrams may overtake each other or be lost.
    fn may_answer_unknown(&self, connection: Connection<'_>) -> bool {
        self.num_without_id > 0 || !connection.is_ordered
    }

    /// Adds an id, unless it is a string.
    fn add_odd_id(&mut self, id: Option<&Tree<'_>>) {
        let Some(id) = id.filter(|id| !matches!(id, Tree::Text(_))) else { return };
        let text = id.to_string();
        if self.odd_ids.len() < MAX_ODD_IDS && text.len() <= MAX_ID {
            self.odd_ids.push(text);
        }
    }

    /// Adds a message without a usable id.
    fn add_without_id(&mut self) {
        self.unknown = Unknown::Message;
        self.num_without_id = self.num_without_id.saturating_add(1);
    }
}

/// All connections of a capture.
#[derive(Debug)]
pub struct Sessions {
    /// The connection states, by connection index.
    states: Vec<State>,
    serials: u64,
    /// The pending requests.
    open: Remembered<(u64, Side, String), SentRequest>,
    /// The ids of past messages to which `refs` may refer. The value is true for answered requests, and false for
    /// responses from the client.
    past: Remembered<(u64, Side, String), bool>,
    /// The ids of the servers' messages. The value is true for notifications.
    sent: ById<bool>,
    operations: Operations,
    /// The requests that may have adjusted the server's clock.
    adjustments: Adjustments,
}

impl Default for Sessions {
    fn default() -> Self {
        Self {
            states: Vec::new(),
            serials: 0,
            open: Remembered::new(MAX_REMEMBERED),
            past: Remembered::new(MAX_REMEMBERED),
            sent: ById::new(MAX_REMEMBERED),
            operations: Operations::new(MAX_REMEMBERED),
            adjustments: Adjustments::default(),
        }
    }
}

impl Sessions {
    /// Determines the context of the next record, including violations of its body schema.
    pub fn follow<'t>(&mut self, record: &'t SessionRecord<'t>, schemas: BodySchemas<'_>) -> Exchange<'t> {
        let mut exchange = Exchange::new(record, self.reliable_time(record));
        exchange.answers_unknown = self.answers_unknown(&exchange, schemas);
        exchange.deviations = exchange.deviations_from(schemas);
        self.resolve(&mut exchange);
        exchange.note_misplaced();
        let refs = exchange.message().and_then(|message| message.get("refs"));
        let is_null_copy = exchange.role == Role::Notification && refs.is_some();
        exchange.copies_id &= exchange.answers_unknown || !is_null_copy;
        if exchange.answers_unknown || is_null_copy {
            let state = &mut self.states[record.connection.index];
            state.num_without_id = state.num_without_id.saturating_sub(1);
        }
        exchange
    }

    /// True if a record is the answer to a message that has no usable id. Such an answer has no `refs` either, or copies
    /// an id that is null. Its type isn't usual for notifications.
    pub fn is_answer_to_unknown(&self, record: &SessionRecord<'_>, schemas: BodySchemas<'_>) -> bool {
        self.answers_unknown(&Exchange::new(record, None), schemas)
    }

    /// Like [`follow`](Self::follow), but completes the existing exchange of a notification that has already been
    /// checked.
    pub fn follow_checked(&mut self, exchange: &mut Exchange<'_>) {
        exchange.time = self.reliable_time(exchange.record);
        self.resolve(exchange);
    }

    /// Adds the session context to an exchange.
    fn resolve(&mut self, exchange: &mut Exchange<'_>) {
        let record = exchange.record;
        let state = &self.states[record.connection.index];
        exchange.clock = state.clock.at(exchange.time, &self.adjustments);
        exchange.is_clock_set_back = self.adjustments.may_set_back();
        exchange.serial = state.serial;
        exchange.copies_id = exchange
            .message()
            .and_then(|message| message.get("refs"))
            .is_some_and(|refs| !matches!(refs, Tree::Text(_)) && state.odd_ids.contains(&refs.to_string()));
        match exchange.role {
            Role::Event | Role::Unanswered => {}
            // Like a lost message, an unreadable message may have been any message.
            Role::Unreadable if record.direction == Direction::In => {
                self.lose_connection(record.connection.index);
            }
            Role::Unreadable => self.sent_unreadable(record.connection.index),
            Role::Request => self.request(exchange),
            Role::Response => self.response(exchange),
            Role::Notification => self.notification(exchange),
        }
    }

    /// Resets the state of a connection that ended or restarted. Returns its serial and its unanswered requests.
    pub fn ended(&mut self, connection: usize) -> (u64, Vec<SentRequest>) {
        let serial = self.next_serial();
        let Some(state) = self.states.get_mut(connection) else { return (serial, Vec::new()) };
        let state = std::mem::replace(state, State::partial(serial));
        let (serial, last_received) = (state.serial, state.last_received);
        let is_sound = !state.is_time_lost;
        let waited = |request: SentRequest| SentRequest {
            waited: last_received
                .zip(request.time)
                .filter(|_| is_sound)
                .map(|(last_received, time)| last_received - time),
            ..request
        };
        let first = (serial, Side::Client, String::new());
        let is_pending = |key: &(u64, Side, String)| key.0 == serial && key.1 == Side::Client;
        // After announcing the end, a server needn't answer requests in transit.
        let is_wanted = |request: &SentRequest| {
            state
                .ending
                .is_none_or(|ending| request.time.is_some_and(|time| time < ending - MAX_TRANSIT_TIME))
        };
        let open = self.open.take(&first, is_pending).into_iter();
        (serial, open.filter(is_wanted).map(waited).collect())
    }

    /// Resets the state of a connection that opens.
    pub fn opened(&mut self, connection: usize) {
        let serial = self.next_serial();
        self.grow(connection);
        self.states[connection] = State { serial, is_whole: true, ..State::default() };
    }

    /// Handles the failure of the latest request over HTTP. HTTP requests fail independently of each other.
    pub fn failed(&mut self, connection: usize, why: Option<&str>) {
        let Some(state) = self.states.get(connection) else { return };
        let Some(id) = &state.latest_request else { return };
        let key = (state.serial, Side::Client, id.clone());
        if let Some(request) = self.open.remove(&key) {
            let failure = why.map(|why| why.chars().take(MAX_FAILURE).collect());
            let size = id.len() + request.size() + MAX_FAILURE;
            self.open.insert(key, SentRequest { failure, ..request }, size);
        }
    }

    /// Handles text from the client that can't be read. The server may be able to read and answer it.
    pub fn sent_unreadable(&mut self, connection: usize) {
        self.grow(connection);
        let state = &mut self.states[connection];
        (state.unknown, state.num_without_id) = (Unknown::Message, u64::MAX);
    }

    /// Handles a piece of a message from the client. `is_incomplete` is true if other pieces must follow.
    pub fn sending(&mut self, connection: usize, is_incomplete: bool) {
        self.grow(connection);
        let state = &mut self.states[connection];
        if state.unknown != Unknown::Message {
            state.unknown = if is_incomplete { Unknown::Piece } else { Unknown::Nothing };
        }
    }

    /// Handles an unreadable part of the capture, which may have contained records of any connection.
    pub fn lose(&mut self) {
        self.open.clear();
        self.past.clear();
        self.operations.clear();
        for state in &mut self.states {
            (state.is_whole, state.num_without_id) = (false, u64::MAX);
            state.clock.forget();
        }
    }

    /// Like `lose`, for one connection. A new serial separates the connection's later records from all earlier records.
    fn lose_connection(&mut self, connection: usize) {
        let serial = self.next_serial();
        let state = &mut self.states[connection];
        (state.serial, state.is_whole, state.num_without_id) = (serial, false, u64::MAX);
        state.clock.forget();
    }

    fn next_serial(&mut self) -> u64 {
        self.serials += 1;
        self.serials
    }

    /// Adds the state of connections whose start is unknown.
    fn grow(&mut self, connection: usize) {
        while self.states.len() <= connection {
            let serial = self.next_serial();
            self.states.push(State::partial(serial));
        }
    }

    /// The time of a record, if it is reliable.
    fn reliable_time(&mut self, record: &SessionRecord<'_>) -> Option<f64> {
        self.grow(record.connection.index);
        let state = &mut self.states[record.connection.index];
        let time = record.time?;
        if time < state.latest - MAX_CLOCK_JITTER {
            state.is_time_lost = true;
            state.clock.forget();
        }
        state.latest = state.latest.max(time);
        if state.is_time_lost {
            return None;
        }
        if record.direction == Direction::In {
            state.last_received = Some(time);
        }
        Some(time)
    }

    fn request(&mut self, exchange: &mut Exchange<'_>) {
        let side = side(exchange);
        let request = SentRequest::new(exchange);
        let state = &mut self.states[exchange.record.connection.index];
        if side == Side::Client {
            self.adjustments.request(exchange, &request);
            state.clock.request(exchange, &request);
            self.operations.release(state.serial, &request);
        }
        let id = exchange.id.filter(|id| id.len() <= MAX_ID);
        state.latest_request = id.filter(|_| side == Side::Client).map(str::to_owned);
        let Some(id) = id else {
            // The answer to this message may have any `refs`.
            state.is_whole = false;
            state.add_odd_id(exchange.record.value.and_then(|message| message.get("id")));
            return state.add_without_id();
        };
        let key = (state.serial, side, id.to_owned());
        exchange.is_id_in_use = exchange.record.connection.is_ordered && self.open.contains(&key);
        let request = match self.open.remove(&key) {
            None => request,
            // A datagram may be lost, so a client may send a request again. Any answer then belongs to the request.
            Some(known) if !exchange.record.connection.is_ordered && known.is_repeated_by(&request) => known,
            Some(known) => SentRequest { is_ambiguous: true, count: known.count + 1, ..request },
        };
        let room = id.len() + request.size();
        self.open.insert(key, request, room);
    }

    fn response(&mut self, exchange: &mut Exchange<'_>) {
        let from = side(exchange);
        if from == Side::Server {
            self.send(exchange, false);
        }
        self.refer(exchange, if from == Side::Server { Side::Client } else { Side::Server });
        if from == Side::Client {
            self.remember_response(exchange);
        }
        if from == Side::Server {
            let state = &mut self.states[exchange.record.connection.index];
            state.clock.answer(exchange, &mut self.adjustments);
            self.operations.answer(exchange, state.serial);
        }
    }

    /// Records the id of a client's response, because a server may refuse an unexpected response, and refer to its id.
    fn remember_response(&mut self, exchange: &Exchange<'_>) {
        let state = &mut self.states[exchange.record.connection.index];
        let Some(id) = exchange.id.filter(|id| id.len() <= MAX_ID) else {
            return state.add_without_id();
        };
        let key = (state.serial, Side::Client, id.to_owned());
        if !self.past.contains(&key) {
            self.past.insert(key, false, id.len());
        }
    }

    /// Determines which message the `refs` of an exchange refers to.
    fn refer(&mut self, exchange: &mut Exchange<'_>, asker: Side) {
        let connection = exchange.record.connection;
        let state = &self.states[connection.index];
        let is_certain = state.is_whole
            && state.unknown == Unknown::Nothing
            && connection.is_ordered
            && !self.open.has_forgotten()
            && !self.past.has_forgotten();
        // A server may copy an id that isn't a string from a message that the capture lacks.
        if exchange.refs.is_none() && is_certain {
            exchange.reference = Reference::Unknown;
        }
        let Some(refs) = exchange.refs.filter(|refs| refs.len() <= MAX_ID) else { return };
        let key = (state.serial, asker, refs.to_owned());
        if let Some(request) = self.open.remove(&key) {
            exchange.reference = Reference::Request;
            let size = refs.len() + request.size();
            if request.count > 1 {
                self.open.insert(key, SentRequest { count: request.count - 1, ..request }, size);
                return;
            }
            self.past.insert(key, true, refs.len());
            exchange.request = Some(request).filter(|request| !request.is_ambiguous);
        } else if let Some(is_request) = self.past.get(&key) {
            let is_answered = *is_request && connection.is_ordered;
            exchange.reference = if is_answered { Reference::Answered } else { Reference::Unclear };
        } else {
            let named = self.sent.get(&(state.serial, refs.to_owned())).copied();
            exchange.reference = match named {
                // `refs` may also name the response itself, which isn't a notification.
                Some(true) if is_certain => Reference::Notification,
                _ if is_certain => Reference::Unknown,
                _ => Reference::Unclear,
            };
            if asker == Side::Client
                && exchange.reference == Reference::Unclear
                && exchange.type_name == Some("SYS-TIME")
            {
                // The capture may lack a request that adjusted the clock.
                self.adjustments.may_follow(exchange.time.map(|time| time + MAX_CLOCK_JITTER));
            }
        }
    }

    fn notification(&mut self, exchange: &mut Exchange<'_>) {
        self.send(exchange, true);
        let connection = exchange.record.connection;
        exchange.may_answer_unknown = self.states[connection.index].may_answer_unknown(connection);
        if exchange.type_name == Some("SYS-CLOSE") {
            self.states[connection.index].ending = exchange.time;
        }
        let State { serial, is_whole, .. } = self.states[connection.index];
        self.operations.notification(exchange, serial, is_whole);
    }

    /// True if a message without `refs` answers a message without an id.
    fn answers_unknown(&self, exchange: &Exchange<'_>, schemas: BodySchemas<'_>) -> bool {
        let connection = exchange.record.connection;
        let state = self.states.get(connection.index);
        let is_expected = state.is_none_or(|state| state.may_answer_unknown(connection));
        if !is_expected || exchange.role != Role::Notification || exchange.message().is_none() {
            return false;
        }
        // The description of OBJ-CMD says that results are sent in notifications of this type.
        let is_usual = |name: &str| {
            let defined = schemas.defined_schemas;
            // A user's schemas may be for one direction only.
            let is_defined = defined.is_defined(name, json_type::Direction::Notification);
            name == "OBJ-CMD" || is_defined || !defined.has(name)
        };
        exchange.type_name.is_some_and(|name| !is_usual(name))
    }

    /// Records the id of a server's message.
    fn send(&mut self, exchange: &mut Exchange<'_>, is_notification: bool) {
        let connection = exchange.record.connection;
        let Some(id) = exchange.id.filter(|id| id.len() <= MAX_ID) else { return };
        let serial = self.states[connection.index].serial;
        if connection.is_ordered {
            exchange.is_id_in_use = !self.sent.insert_new((serial, id.to_owned()), is_notification, id.len());
        } else {
            self.sent.insert((serial, id.to_owned()), is_notification, id.len());
        }
    }
}

fn side(exchange: &Exchange<'_>) -> Side {
    if exchange.record.direction == Direction::In { Side::Server } else { Side::Client }
}
