//! A probe's connection. All of its messages are recorded.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

use serde_json::value::RawValue;
use serde_json::{Value, json};
use uavspec_flockwave::record::{Direction, Trial};
use uavspec_flockwave::transport::access::Access;
use uavspec_flockwave::transport::client::{Client, Network, Received, connect_with, http_status};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::clock::Clock;

use super::INTERRUPTED;
use super::stop::{NOTICE_TIME, Stop};
use super::tape::{TOO_LONG, Tape};
use crate::limits::{MAX_LATE, MAX_WAITING};

/// The reason that is recorded if the server closes a connection.
const CLOSED: &str = "eof";

/// The time after which a connection is idle.
const IDLE_TIME: Duration = Duration::from_secs(5);

/// The time limit for reading the remaining messages after the server has closed the connection.
const DRAIN_TIMEOUT: Duration = Duration::from_millis(200);

/// The kind of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A byte stream, in which messages may be split.
    Stream,
    /// Datagrams, which may be lost.
    Datagrams,
    /// HTTP requests, one for each message. Requests fail independently of each other.
    OneShot,
    /// Socket.IO events.
    Events,
}

/// The way in which a server is reached.
pub(super) struct Path<'p> {
    pub(super) endpoint: &'p Endpoint,
    pub(super) access: &'p Access,
    /// A network in memory; `None` for the network of the system.
    pub(super) network: Option<&'p dyn Network>,
    /// The time limit for connecting.
    pub(super) limit: Duration,
    /// The time for which each request may remain unanswered.
    pub(super) patience: Duration,
    pub(super) stop: &'p Stop,
    pub(super) clock: &'p Clock,
}

impl Path<'_> {
    fn connect(&self) -> io::Result<Link> {
        if let Some(network) = self.network {
            return network.connect(self.endpoint).map(Link::Local);
        }
        let (endpoint, access) = (self.endpoint.clone(), self.access.clone());
        let until = self.clock.now() + self.limit;
        let connected = self.stop.run(move || connect_with(&endpoint, &access, until));
        connected.unwrap_or_else(|| Err(interrupted())).map(Link::Remote)
    }
}

/// A client and its calls.
enum Link {
    /// Calls may block, so they run in another thread.
    Remote(Box<dyn Client + Send>),
    /// Calls don't block.
    Local(Box<dyn Client>),
}

impl Link {
    fn client(&mut self) -> &mut dyn Client {
        match self {
            Self::Remote(client) => client.as_mut(),
            Self::Local(client) => client.as_mut(),
        }
    }
}

/// A connection.
pub(super) struct Session {
    pub(super) name: String,
    kind: Kind,
    /// The time for which a request may remain unanswered.
    patience: Duration,
    /// The connection to the server. `None` after an interrupted call.
    link: Option<Link>,
    /// Ends waiting early.
    stop: Stop,
    clock: Clock,
    /// The unanswered requests, by id, each with the time at which it was sent.
    waiting: BTreeMap<String, Instant>,
    /// The ids of answered requests.
    answered: BTreeSet<String>,
    /// The time of the latest answer that left another request unanswered. That request was sent together with the
    /// answered request, or later.
    answered_at: Option<Instant>,
    /// The ids of the HTTP requests whose responses haven't been read, in order. `None` for a message without an id.
    unread: VecDeque<Option<String>>,
    /// The number of answers without an envelope.
    pub(super) bare: u64,
    /// The time of the latest message from the client.
    sent_at: Instant,
    /// True if the connection is being read to its end after sending failed.
    is_draining: bool,
    /// True if the server announced the end of the connection with SYS-CLOSE.
    pub(super) is_announced: bool,
    /// The reason why an HTTP request failed, for the latest failed request.
    failed: Option<String>,
    /// The HTTP status of the response to that request.
    failed_status: Option<u16>,
    /// The reason for the end of the connection, if it has ended.
    end: Option<String>,
}

impl Session {
    /// Connects to a server. The number makes the name of the connection unique.
    pub(super) fn open(path: &Path<'_>, number: usize, tape: &mut Tape<'_>) -> io::Result<Self> {
        let link = path.connect()?;
        let name = name(path.endpoint, number);
        tape.connected(&name, &path.endpoint.to_string());
        let kind = match path.endpoint {
            Endpoint::Tcp(_) => Kind::Stream,
            Endpoint::Udp(_) => Kind::Datagrams,
            Endpoint::Http { .. } => Kind::OneShot,
            Endpoint::SocketIo { .. } => Kind::Events,
        };
        Ok(Self {
            name,
            kind,
            patience: path.patience,
            link: Some(link),
            stop: path.stop.clone(),
            clock: path.clock.clone(),
            waiting: BTreeMap::new(),
            answered: BTreeSet::new(),
            answered_at: None,
            unread: VecDeque::new(),
            bare: 0,
            sent_at: path.clock.now(),
            is_draining: false,
            is_announced: false,
            failed: None,
            failed_status: None,
            end: None,
        })
    }

    /// True if messages are sent over a byte stream, in which they may be split.
    pub(super) fn is_stream(&self) -> bool {
        self.kind == Kind::Stream
    }

    fn is_one_shot(&self) -> bool {
        self.kind == Kind::OneShot
    }

    /// True if the client has not sent a request for a while.
    pub(super) fn is_idle(&self) -> bool {
        !self.is_over() && self.idle_time() > IDLE_TIME
    }

    /// The time since the latest message from the client.
    pub(super) fn idle_time(&self) -> Duration {
        self.clock.now().saturating_duration_since(self.sent_at)
    }

    /// True if messages may be lost.
    pub(super) fn is_lossy(&self) -> bool {
        self.kind == Kind::Datagrams
    }

    /// True if the connection has ended.
    pub(super) fn is_over(&self) -> bool {
        self.end.is_some()
    }

    /// The reason for the end of the connection, as a clause.
    pub(super) fn why_over(&self) -> String {
        match self.end.as_deref() {
            None | Some(CLOSED) => format!("the server closed connection {}", self.name),
            Some(why) => format!("connection {} failed: {why}", self.name),
        }
    }

    /// The reason for the end of the connection or for the latest failed HTTP request, if any.
    pub(super) fn trouble(&self) -> Option<String> {
        self.failed.clone().or_else(|| self.is_over().then(|| self.why_over()))
    }

    /// True if the latest HTTP request failed because of a missing or wrong login.
    pub(super) fn is_refused_login(&self) -> bool {
        matches!(self.failed_status, Some(401 | 403 | 407))
    }

    /// True if a missing answer may still arrive on this connection.
    pub(super) fn is_pending(&self) -> bool {
        // A server may handle requests one after the other.
        let latest = self.waiting.values().copied().chain(self.answered_at).max();
        // A missing answer over UDP proves nothing.
        !self.is_over()
            && self.kind != Kind::Datagrams
            && self.is_waiting()
            && latest.is_some_and(|latest| self.clock.now().saturating_duration_since(latest) < self.patience)
    }

    /// True if at least one request has no answer yet.
    pub(super) fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// The number of requests without an answer.
    pub(super) fn num_waiting(&self) -> usize {
        self.waiting.len()
    }

    /// True if this request was answered.
    pub(super) fn has_answer(&self, id: &str) -> bool {
        self.answered.contains(id)
    }

    /// True if this request has no answer yet.
    pub(super) fn awaits(&self, id: &str) -> bool {
        self.waiting.contains_key(id)
    }

    /// Sends a message, which may be invalid. If the message has an id, an answer is expected.
    pub(super) fn send(
        &mut self,
        tape: &mut Tape<'_>,
        text: &[u8],
        id: Option<&str>,
        trial: Option<Trial<'_>>,
    ) {
        self.note(tape, text, id, trial);
        let message = text.to_vec();
        let sent = self.call(move |client| client.send(&message));
        match sent {
            // HTTP requests fail independently of each other.
            Err(error)
                if self.is_one_shot()
                    && matches!(error.kind(), ErrorKind::InvalidData | ErrorKind::TimedOut) =>
            {
                // A server may refuse a malformed message.
                let is_refusal = http_status(&error).is_some_and(|status| (400..500).contains(&status));
                let trial = trial.filter(|_| id.is_none() && !is_refusal);
                self.failed_status = http_status(&error);
                self.fails(tape, id, &error.to_string(), trial);
            }
            sent => {
                if sent.is_ok() && self.is_one_shot() {
                    self.unread.push_back(id.map(str::to_owned));
                }
                self.handle_send(tape, sent);
            }
        }
    }

    /// Records that the latest HTTP request has no valid response.
    fn fails(&mut self, tape: &mut Tape<'_>, id: Option<&str>, why: &str, trial: Option<Trial<'_>>) {
        tape.event(&self.name, "failed", why, trial);
        self.failed = Some(why.to_owned());
        self.waiting.retain(|waiting, _| Some(waiting.as_str()) != id);
    }

    /// Records a message that is sent with `send_raw`.
    pub(super) fn note(
        &mut self,
        tape: &mut Tape<'_>,
        text: &[u8],
        id: Option<&str>,
        trial: Option<Trial<'_>>,
    ) {
        // A message without an id can't be answered, so it tests nothing by itself.
        tape.message(&self.name, Direction::Out, text, trial.filter(|_| id.is_some()));
        self.sent_at = self.clock.now();
        if let Some(id) = id.filter(|_| self.waiting.len() < MAX_WAITING) {
            self.waiting.insert(id.to_owned(), self.clock.now());
        }
    }

    /// Sends bytes without recording them.
    pub(super) fn send_raw(&mut self, tape: &mut Tape<'_>, bytes: &[u8]) {
        let bytes = bytes.to_vec();
        let sent = self.call(move |client| client.send_raw(&bytes));
        self.handle_send(tape, sent);
    }

    /// Calls the client, which may block. If the probe must stop in the meantime, the connection ends, unless the call
    /// sends commands to UAVs: such a command could arrive after the command that undoes it.
    fn call(
        &mut self,
        work: impl FnOnce(&mut dyn Client) -> io::Result<()> + Send + 'static,
    ) -> io::Result<()> {
        let mut client = match self.link.take().ok_or_else(interrupted)? {
            Link::Remote(client) if self.stop.commanded().is_safe() => client,
            mut link => {
                let done = work(link.client());
                self.link = Some(link);
                return done;
            }
        };
        let done = self.stop.run(move || {
            let done = work(client.as_mut());
            (client, done)
        });
        let (client, done) = done.ok_or_else(interrupted)?;
        self.link = Some(Link::Remote(client));
        done
    }

    /// Waits for a time without reading. Returns early if the probe must stop.
    pub(super) fn pause(&self, time: Duration) {
        self.stop.sleep(&self.clock, time);
    }

    /// Waits for the next JSON message.
    pub(super) fn receive(&mut self, tape: &mut Tape<'_>, until: Instant) -> Option<Value> {
        while let Some(link) = self.link.as_mut().filter(|_| self.end.is_none()) {
            // A server that never stops sending can't delay the end of the wait.
            if self.stop.is_due() {
                return None;
            }
            match link.client().receive(until.min(self.clock.now() + NOTICE_TIME)) {
                // Blank lines and empty answers aren't messages.
                Ok(Received::Message(bytes)) if bytes.trim_ascii().is_empty() => {
                    if let Some(Some(id)) = self.unread.pop_front().filter(|_| self.is_one_shot()) {
                        self.fails(tape, Some(&id), "the response is empty", None);
                    }
                }
                Ok(Received::Message(bytes)) => match self.enveloped(bytes) {
                    Ok(bytes) => {
                        tape.message(&self.name, Direction::In, &bytes, None);
                        if let Ok(message) = serde_json::from_slice::<Value>(&bytes) {
                            self.take(tape, &message);
                            return Some(message);
                        }
                    }
                    Err(bytes) => tape.other_event(&self.name, &bytes),
                },
                Ok(Received::OtherEvent(bytes)) => tape.other_event(&self.name, &bytes),
                Ok(Received::TooLong) => tape.message(&self.name, Direction::In, TOO_LONG, None),
                Ok(Received::Silence) => {}
                Ok(Received::End) => self.end(tape, CLOSED),
                Err(error) => self.fail(tape, &error),
            }
            if self.clock.now() >= until {
                return None;
            }
        }
        None
    }

    /// Reads messages until all requests have been answered, or until the time limit.
    pub(super) fn settle(&mut self, tape: &mut Tape<'_>, until: Instant) {
        while self.is_waiting() && self.clock.now() < until && self.receive(tape, until).is_some() {}
    }

    /// Reads the messages that have already arrived.
    pub(super) fn catch_up(&mut self, tape: &mut Tape<'_>) {
        let until = self.clock.now() + Duration::from_millis(1);
        for _ in 0..MAX_LATE {
            if self.receive(tape, until).is_none() {
                break;
            }
        }
    }

    /// Waits for the answer to a request.
    pub(super) fn answer(&mut self, tape: &mut Tape<'_>, id: &str, until: Instant) -> Option<Value> {
        // No answer arrives for an HTTP request that has failed.
        if self.is_one_shot() && !self.awaits(id) {
            return None;
        }
        self.find(tape, until, |message| message["refs"] == id)
    }

    /// Waits for a message that matches a predicate.
    pub(super) fn find(
        &mut self,
        tape: &mut Tape<'_>,
        until: Instant,
        is_wanted: impl Fn(&Value) -> bool,
    ) -> Option<Value> {
        while let Some(message) = self.receive(tape, until) {
            if is_wanted(&message) {
                return Some(message);
            }
            // A flood of other messages must not extend the time limit.
            if self.clock.now() >= until {
                break;
            }
        }
        None
    }

    /// Closes the connection. If an answer may still arrive, the end isn't recorded, so that the missing answer doesn't
    /// violate a rule.
    pub(super) fn close(mut self, tape: &mut Tape<'_>) {
        if !self.is_pending() {
            self.end(tape, "client");
        }
    }

    /// Adds an envelope to an HTTP answer that lacks one. The specification doesn't define this transport, and some
    /// servers answer with only the body, because each HTTP response belongs to a known request. If the request had no
    /// id, the answer is returned as an error, without an envelope.
    fn enveloped(&mut self, bytes: Vec<u8>) -> Result<Vec<u8>, Vec<u8>> {
        let request = self.unread.pop_front().flatten();
        let Some(body) = bare(&bytes).filter(|_| self.is_one_shot()) else { return Ok(bytes) };
        let Some(request) = request else { return Err(bytes) };
        self.bare += 1;
        let (id, refs) = (format!("bare-{}", self.bare), Value::from(request));
        Ok(format!(r#"{{"$fw.version":"1.0","id":"{id}","refs":{refs},"body":{}}}"#, body.get()).into_bytes())
    }

    /// Processes a message: marks its request as answered, or answers a ping from the server.
    fn take(&mut self, tape: &mut Tape<'_>, message: &Value) {
        self.is_announced |= message["body"]["type"] == "SYS-CLOSE";
        self.stop.commanded().received(&message["body"]);
        if let Some(refs) = message["refs"].as_str() {
            let answered = self.waiting.remove(refs);
            if answered.is_some() && self.answered.len() < MAX_WAITING {
                self.answered.insert(refs.to_owned());
            }
            if answered.is_some_and(|sent_at| self.waiting.values().any(|waiting| *waiting >= sent_at)) {
                self.answered_at = Some(self.clock.now());
            }
        } else if message["body"]["type"] == "SYS-PING"
            && !self.is_draining
            && let Some(id) = message["id"].as_str()
        {
            let start: String = id.chars().take(30).collect();
            let answer = json!({
                "$fw.version": "1.0", "id": format!("re-{start}"), "refs": id, "body": { "type": "ACK-ACK" },
            });
            self.send(tape, answer.to_string().as_bytes(), None, None);
        }
    }

    fn handle_send(&mut self, tape: &mut Tape<'_>, sent: io::Result<()>) {
        let Err(error) = sent else { return };
        if self.stop.is_due() {
            // Messages that have already arrived haven't been read, so the end proves nothing.
            self.end.get_or_insert_with(|| error.to_string());
        } else if is_end(&error) {
            // Messages sent before the end of the connection still count.
            self.is_draining = true;
            let until = self.clock.now() + DRAIN_TIMEOUT;
            while self.receive(tape, until).is_some() {}
            self.end(tape, CLOSED);
        } else {
            self.fail(tape, &error);
        }
    }

    fn fail(&mut self, tape: &mut Tape<'_>, error: &io::Error) {
        if is_end(error) { self.end(tape, CLOSED) } else { self.end(tape, &error.to_string()) }
    }

    fn end(&mut self, tape: &mut Tape<'_>, why: &str) {
        if self.end.is_none() {
            self.end = Some(why.to_owned());
            tape.event(&self.name, "closed", why, None);
        }
    }
}

/// The name of a connection. It starts with the transport, because some rules depend on the transport.
pub(super) fn name(endpoint: &Endpoint, number: usize) -> String {
    format!("{}#{number}", endpoint.scheme())
}

/// The body, if an answer has no envelope.
fn bare(bytes: &[u8]) -> Option<&RawValue> {
    let body: &RawValue = serde_json::from_slice(bytes).ok()?;
    let read: Value = serde_json::from_str(body.get()).ok()?;
    (read["type"].is_string() && read.get("$fw.version").is_none()).then_some(body)
}

/// True if the error means that the server closed the connection.
fn is_end(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::BrokenPipe
            | ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::NotConnected
            | ErrorKind::UnexpectedEof
    )
}

/// The error of a call that was interrupted, because the probe must stop.
fn interrupted() -> io::Error {
    io::Error::other(INTERRUPTED)
}
