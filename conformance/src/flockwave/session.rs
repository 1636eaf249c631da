//! What went over connections of Flockwave before: requests that wait for an answer, ids that were used, operations
//! under way. It is kept in this one place, and rules are told of each record what it means ([`Exchange`]).
//!
//! A recording rarely shows all. So only what is certain is called so:
//!
//! - Where the recording doesn't show how a connection began, earlier requests may be unknown.
//! - After damage all that waits is forgotten: what it waits for may have been lost.
//! - Where time goes back, times say nothing any more.
//! - All memories have a bound; what was forgotten for lack of room is unknown, not absent.

mod exchange;
pub(crate) mod ids;
mod operation;
pub(crate) mod remembered;
mod vocabulary;

use std::collections::BTreeSet;

pub(crate) use self::exchange::seconds;
pub(crate) use self::exchange::{ClockMove, ConnectionId, Exchange, Reference, Role};
use self::ids::Ids;
pub(crate) use self::operation::{Named, Operation, Stage};
use self::remembered::Remembered;
pub(crate) use self::vocabulary::OPERATIONS;
pub(crate) use self::vocabulary::parts;
#[cfg(test)]
pub(crate) use self::vocabulary::{OPERATION, PARTS};
use crate::flockwave::body_schema::BodySchemas;
use crate::flockwave::record::{Direction, SessionRecord};
use crate::json::Tree;
use crate::model::{Location, Rule};

/// How much each memory takes, in bytes.
const MEMORY_LIMIT: usize = 16 << 20;

/// The longest id that is kept, in bytes. Ids of messages have 36 characters at most and those of objects 64, each of
/// up to four bytes.
const MAX_ID: usize = 256;

/// How many ids of a request are kept; more say nothing.
const MAX_REQUEST_IDS: usize = 10_000;

/// How many receipts of a message are looked at.
const MAX_RECEIPTS: usize = 10_000;

/// By how much time may go back and yet be sound, in seconds: several threads may write a recording.
const MAX_CLOCK_JITTER: f64 = 0.5;

/// How long a request may have been on its way, in seconds.
const MAX_TRANSIT_TIME: f64 = 1.0;

/// A request that was sent.
#[derive(Clone, Debug)]
pub(crate) struct SentRequest {
    /// Its type, where it says one.
    pub type_name: Option<String>,
    /// What it asks for, where that is a list of strings, all of them kept.
    pub objects: Option<BTreeSet<String>>,
    /// One of them that it names twice.
    pub repeated: Option<String>,
    /// The types of objects that it has as a filter, where it has one; none of them where that is no list of strings.
    pub filter: Option<BTreeSet<String>>,
    /// Whether it sets what it could ask for: a source of RTK, or the time.
    pub is_setting: bool,
    /// When it was sent.
    pub time: Option<f64>,
    /// Where it stands.
    pub location: Location,
    /// How much later the latest message of the server came, in seconds, where this is told of a request without an
    /// answer.
    pub waited: Option<f64>,
    /// Whether it is a request of Flockwave by its envelope: with a version, and a type.
    pub is_sound: bool,
    /// What is tried with it: a rule, and how.
    pub trial: Option<(&'static Rule, String)>,
    /// Whether its id was in use when it was sent, so that nobody can tell which of them an answer is about.
    is_ambiguous: bool,
    /// How many requests with this id wait.
    count: u64,
}

/// Which side of a connection sent something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Client,
    Server,
}

/// What is known of a connection.
#[derive(Clone, Debug, Default)]
struct State {
    /// Tells it from those that had the same name before.
    serial: u64,
    /// Whether all that went over it is known.
    is_whole: bool,
    /// The latest time.
    latest: f64,
    /// When the latest message of the server came.
    last_received: Option<f64>,
    /// Whether time went back.
    is_time_lost: bool,
    /// When the server said that the connection ends.
    ending: Option<f64>,
    /// By how much the server's clock is ahead of the recording's: bounds, in seconds.
    clock: Option<(f64, f64)>,
    /// When that was learnt.
    clock_time: f64,
    /// Where the server was asked to adjust its clock by nothing, as long as no later request has told what came of it.
    adjusted_by_nothing: Option<Location>,
}

/// All connections of a source.
#[derive(Debug)]
pub(crate) struct Sessions {
    /// By index.
    states: Vec<State>,
    serials: u64,
    /// Requests without an answer.
    open: Remembered<(u64, Side, String), SentRequest>,
    /// Ids of requests that were answered.
    answered: Remembered<(u64, Side, String), ()>,
    /// Ids of messages of servers, and whether each was a notification.
    sent: Ids<bool>,
    /// By receipt.
    operations: Ids<Operation>,
}

impl Default for Sessions {
    fn default() -> Self {
        Self {
            states: Vec::new(),
            serials: 0,
            open: Remembered::new(MEMORY_LIMIT),
            answered: Remembered::new(MEMORY_LIMIT),
            sent: Ids::new(MEMORY_LIMIT),
            operations: Ids::new(MEMORY_LIMIT),
        }
    }
}

impl Sessions {
    /// A record with what it means after all that precedes it, and with the violations of its body schema.
    pub(crate) fn follow<'t>(
        &mut self,
        record: &'t SessionRecord<'t>,
        schemas: BodySchemas<'_>,
    ) -> Exchange<'t> {
        let time = self.at(record);
        let exchange = Exchange::new(record, time);
        let deviations = exchange.deviations_from(schemas);
        self.resolve(Exchange { deviations, ..exchange })
    }

    /// Like [`follow`](Self::follow), for a record whose message was checked already.
    pub(crate) fn follow_checked<'t>(&mut self, record: &'t SessionRecord<'t>) -> Exchange<'t> {
        let time = self.at(record);
        self.resolve(Exchange { deviations: Some(Vec::new()), ..Exchange::new(record, time) })
    }

    /// An exchange with its place in the session.
    fn resolve<'t>(&mut self, mut exchange: Exchange<'t>) -> Exchange<'t> {
        let record = exchange.record;
        let state = &self.states[record.connection.index];
        exchange.clock = state.clock;
        exchange.serial = state.serial;
        match exchange.role {
            Role::Event | Role::Unanswered => {}
            Role::Unreadable => {
                // Nobody knows what it was, as little as of what was lost.
                if record.direction == Direction::In {
                    self.lose_of(record.connection.index);
                }
            }
            Role::Request => self.request(&mut exchange),
            Role::Response => self.response(&mut exchange),
            Role::Notification => self.notification(&mut exchange),
        }
        exchange
    }

    /// The requests that got no answer until a connection ended, or began anew, with what told that connection from
    /// others. Nothing is known of what follows.
    pub(crate) fn ended(&mut self, connection: usize) -> (u64, Vec<SentRequest>) {
        let serial = self.next_serial();
        let Some(state) = self.states.get_mut(connection) else { return (serial, Vec::new()) };
        let state = std::mem::replace(state, State { serial, ..State::default() });
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
        let is_of = |key: &(u64, Side, String)| key.0 == serial && key.1 == Side::Client;
        // Who has said farewell, needn't answer what was on its way to him.
        let is_wanted = |request: &SentRequest| {
            state
                .ending
                .is_none_or(|ending| request.time.is_some_and(|time| time < ending - MAX_TRANSIT_TIME))
        };
        let open = self.open.take(&first, is_of).into_iter();
        (serial, open.filter(is_wanted).map(waited).collect())
    }

    /// A connection is opened; what had its name before is over.
    pub(crate) fn opened(&mut self, connection: usize) {
        let serial = self.next_serial();
        self.grow(connection);
        self.states[connection] = State { serial, is_whole: true, ..State::default() };
    }

    /// Something can't be read, and exchanges of any connection may be lost with it.
    pub(crate) fn lose(&mut self) {
        self.open.clear();
        self.answered.clear();
        self.operations.clear();
        for state in &mut self.states {
            state.is_whole = false;
            state.clock = None;
        }
    }

    /// The same, of one connection. All that is known of it stays behind with its old serial.
    fn lose_of(&mut self, connection: usize) {
        let serial = self.next_serial();
        let state = &mut self.states[connection];
        *state = State { serial, is_whole: false, clock: None, ..state.clone() };
    }

    fn next_serial(&mut self) -> u64 {
        self.serials += 1;
        self.serials
    }

    /// Makes room for a connection whose beginning isn't known.
    fn grow(&mut self, connection: usize) {
        while self.states.len() <= connection {
            let serial = self.next_serial();
            self.states.push(State { serial, ..State::default() });
        }
    }

    /// The time of a record, where it can be trusted.
    fn at(&mut self, record: &SessionRecord<'_>) -> Option<f64> {
        self.grow(record.connection.index);
        let state = &mut self.states[record.connection.index];
        let time = record.time?;
        if time < state.latest - MAX_CLOCK_JITTER {
            state.is_time_lost = true;
            state.clock = None;
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
        if side == Side::Client && request.is_setting && exchange.type_name == Some("SYS-TIME") {
            // Other connections may lead to the same server.
            self.states.iter_mut().for_each(|state| state.clock = None);
        }
        let state = &mut self.states[exchange.record.connection.index];
        if side == Side::Client {
            if exchange.type_name == Some("SYS-TIME") && exchange.field("adjustment") == Some(&Tree::Int(0)) {
                state.adjusted_by_nothing = Some(request.location);
            }
            release(&mut self.operations, state.serial, &request);
        }
        let Some(id) = exchange.id.filter(|id| id.len() <= MAX_ID) else {
            // Its answer may have any `refs`.
            return state.is_whole = false;
        };
        let key = (state.serial, side, id.to_owned());
        exchange.is_id_in_use = exchange.record.connection.is_ordered && self.open.contains(&key);
        let waiting = self.open.remove(&key);
        let count = waiting.as_ref().map_or(1, |request| request.count + 1);
        let request = SentRequest { is_ambiguous: waiting.is_some(), count, ..request };
        let room = id.len() + request.size();
        self.open.insert(key, request, room);
    }

    fn response(&mut self, exchange: &mut Exchange<'_>) {
        let from = side(exchange);
        if from == Side::Server {
            self.send(exchange, false);
        }
        self.refer(exchange, if from == Side::Server { Side::Client } else { Side::Server });
        if from == Side::Server {
            self.learn_time(exchange);
            self.resumed(exchange);
            self.receipts(exchange);
        }
    }

    /// Finds what `refs` is about.
    fn refer(&mut self, exchange: &mut Exchange<'_>, asker: Side) {
        let connection = exchange.record.connection;
        let state = &self.states[connection.index];
        let is_certain = state.is_whole
            && connection.is_ordered
            && !self.open.has_forgotten()
            && !self.answered.has_forgotten();
        let Some(refs) = exchange.refs.filter(|refs| refs.len() <= MAX_ID) else { return };
        let key = (state.serial, asker, refs.to_owned());
        if let Some(request) = self.open.remove(&key) {
            exchange.reference = Reference::Request;
            let size = refs.len() + request.size();
            if request.count > 1 {
                self.open.insert(key, SentRequest { count: request.count - 1, ..request }, size);
                return;
            }
            self.answered.insert(key, (), refs.len());
            exchange.request = Some(request).filter(|request| !request.is_ambiguous);
        } else if self.answered.contains(&key) {
            exchange.reference = if connection.is_ordered { Reference::Answered } else { Reference::Unclear };
        } else {
            let named = self.sent.get_mut(state.serial, refs).copied();
            exchange.reference = match named {
                // A message can't be about itself either, but that is no notification.
                Some(true) if is_certain => Reference::Notification,
                _ if is_certain => Reference::Unknown,
                _ => Reference::Unclear,
            };
        }
    }

    fn notification(&mut self, exchange: &mut Exchange<'_>) {
        self.send(exchange, true);
        if exchange.type_name == Some("SYS-CLOSE") {
            self.states[exchange.record.connection.index].ending = exchange.time;
        }
        let receipts: Vec<String> = match (exchange.type_name, exchange.body) {
            (Some("ASYNC-RESP" | "ASYNC-ST"), Some(body)) => {
                body.get("id").and_then(Tree::as_str).map(str::to_owned).into_iter().collect()
            }
            (Some("ASYNC-TIMEOUT"), Some(body)) => strings(body.get("ids")).unwrap_or_default(),
            _ => return,
        };
        let is_suspended = exchange.field("suspended") == Some(&Tree::Bool(true));
        let is_final = exchange.type_name != Some("ASYNC-ST");
        let State { serial, is_whole, .. } = self.states[exchange.record.connection.index];
        let is_known = is_whole && !self.operations.has_forgotten();
        let mut seen = BTreeSet::new();
        // That a message names one twice is another matter.
        let receipts = receipts.into_iter().filter(|receipt| seen.insert(receipt.clone()));
        for receipt in receipts.take(MAX_RECEIPTS).filter(|receipt| receipt.len() <= MAX_ID) {
            let before = self.operations.remove(serial, &receipt);
            let stage = match &before {
                None if is_known => Stage::Early,
                Some(Operation { stage: Stage::Early, .. }) => Stage::Early,
                _ if is_final => Stage::Ended,
                _ if is_suspended => Stage::Suspended,
                None => Stage::Open,
                // A report on a suspended operation that doesn't say so needn't mean that it goes on.
                Some(operation) => operation.stage,
            };
            let of = before.clone().unwrap_or_default();
            let was_suspended = of.was_suspended || is_suspended || !is_known;
            let size = receipt.len() + of.type_name.as_ref().map_or(0, String::len);
            self.operations.insert(serial, &receipt, Operation { stage, was_suspended, ..of }, size);
            exchange.operations.push(Named { receipt, before, is_known });
        }
    }

    /// A server's message has an id.
    fn send(&mut self, exchange: &mut Exchange<'_>, is_notification: bool) {
        let connection = exchange.record.connection;
        let Some(id) = exchange.id.filter(|id| id.len() <= MAX_ID) else { return };
        let serial = self.states[connection.index].serial;
        exchange.is_id_in_use = connection.is_ordered && self.sent.contains(serial, id);
        if !exchange.is_id_in_use {
            self.sent.insert(serial, id, is_notification, id.len());
        }
    }

    /// What a reply opens.
    fn receipts(&mut self, exchange: &mut Exchange<'_>) {
        let receipts: Vec<String> = match exchange.field("receipt") {
            Some(Tree::Text(receipt)) => vec![receipt.to_string()],
            Some(Tree::Object(members)) => {
                members.iter().filter_map(|(_, receipt)| Some(receipt.as_str()?.to_owned())).collect()
            }
            _ => return,
        };
        let serial = self.states[exchange.record.connection.index].serial;
        for receipt in receipts.into_iter().take(MAX_RECEIPTS).filter(|receipt| receipt.len() <= MAX_ID) {
            let before = self.operations.remove(serial, &receipt);
            let type_name = exchange.type_name.map(str::to_owned);
            let size = receipt.len() + type_name.as_ref().map_or(0, String::len);
            let operation = Operation { type_name, stage: Stage::Open, was_suspended: false };
            self.operations.insert(serial, &receipt, operation, size);
            exchange.opened.push(Named { receipt, before, is_known: exchange.record.connection.is_ordered });
        }
    }

    /// What a client made to go on, or to end.
    fn resumed(&mut self, exchange: &mut Exchange<'_>) {
        if !matches!(exchange.type_name, Some("ASYNC-CANCEL" | "ASYNC-RESUME")) {
            return;
        }
        let serial = self.states[exchange.record.connection.index].serial;
        for receipt in strings(exchange.field("success")).unwrap_or_default() {
            let operation = self.operations.get_mut(serial, &receipt);
            let before = operation.as_deref().cloned();
            // It may have been suspended only after it was asked.
            if let Some(operation) = operation.filter(|known| known.stage == Stage::Suspended) {
                operation.stage = Stage::Released;
            }
            exchange.operations.push(Named {
                receipt,
                before,
                is_known: exchange.record.connection.is_ordered,
            });
        }
    }

    /// Learns how the clocks of both sides stand to each other.
    fn learn_time(&mut self, exchange: &mut Exchange<'_>) {
        let (Some(now), Some(time)) = (exchange.clock_reading(), exchange.time) else { return };
        let state = &mut self.states[exchange.record.connection.index];
        exchange.clock_move = exchange.clock.map(|before| ClockMove {
            // An offset that both answers allow is no move.
            by: (now.0 - before.1).max(before.0 - now.1).max(0.0),
            since: time - state.clock_time,
            is_after_nothing: state.adjusted_by_nothing.is_some(),
        });
        (state.clock, state.clock_time) = (Some(now), time);
        let request = exchange.request.as_ref().map(|request| request.location);
        state.adjusted_by_nothing = state.adjusted_by_nothing.filter(|location| request <= Some(*location));
    }
}

/// What a client resumes or cancels needn't wait any more.
fn release(operations: &mut Ids<Operation>, serial: u64, request: &SentRequest) {
    if !matches!(request.type_name.as_deref(), Some("ASYNC-RESUME" | "ASYNC-CANCEL")) {
        return;
    }
    for receipt in request.objects.iter().flatten() {
        if let Some(operation) = operations.get_mut(serial, receipt)
            && operation.stage == Stage::Suspended
        {
            operation.stage = Stage::Released;
        }
    }
}

fn side(exchange: &Exchange<'_>) -> Side {
    if exchange.record.direction == Direction::In { Side::Server } else { Side::Client }
}

impl SentRequest {
    fn new(exchange: &Exchange<'_>) -> Self {
        let parts = exchange.type_name.and_then(parts);
        let objects = parts.and_then(|parts| strings(exchange.field(parts.request_field)));
        let repeated = objects.as_deref().and_then(repeated);
        let objects: Option<BTreeSet<String>> = objects.map(BTreeSet::from_iter);
        let filter = exchange.field("filter").map(|filter| strings(Some(filter)).unwrap_or_default());
        let is_setting = match exchange.type_name {
            Some("RTK-SOURCE") => exchange.field("id").is_some(),
            Some("SYS-TIME") => exchange.field("adjustment").is_some_and(|by| *by != Tree::Int(0)),
            _ => false,
        };
        Self {
            type_name: exchange.type_name.filter(|name| name.len() <= MAX_ID).map(str::to_owned),
            repeated,
            objects,
            filter: filter.map(BTreeSet::from_iter),
            is_setting,
            time: exchange.time,
            location: exchange.record.location,
            waited: None,
            is_sound: exchange.is_sound(),
            trial: exchange.record.trial.map(|trial| (trial.rule, trial.how.to_owned())),
            is_ambiguous: false,
            count: 1,
        }
    }

    fn size(&self) -> usize {
        let of_object = |object: &String| object.len() + 64;
        let of_trial = self.trial.as_ref().map_or(0, |(_, how)| how.len());
        MAX_ID + of_trial + self.objects.iter().chain(&self.filter).flatten().map(of_object).sum::<usize>()
    }
}

/// One of these that stands there twice.
fn repeated(texts: &[String]) -> Option<String> {
    let mut seen = BTreeSet::new();
    texts.iter().find(|text| !seen.insert(*text)).cloned()
}

/// The strings of a list; none where it is none, holds something else, or holds too much.
fn strings(list: Option<&Tree<'_>>) -> Option<Vec<String>> {
    let Some(Tree::List(values)) = list else { return None };
    let short = |value: &Tree<'_>| Some(value.as_str()?.to_owned()).filter(|text| text.len() <= MAX_ID);
    if values.len() > MAX_REQUEST_IDS { None } else { values.iter().map(short).collect() }
}
