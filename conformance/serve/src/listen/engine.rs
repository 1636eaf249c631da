//! Socket.IO: Engine.IO sessions over WebSocket and long polling, in revisions 3 and 4.

mod session;

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::rc::Rc;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};
use uavspec_flockwave::transport::engine::{Kind, Packet, Revision, decode, encode};
use uavspec_flockwave::transport::http::{Request, Response};
use uavspec_model::clock::Clock;
use uavspec_model::net::is_silence;
use uavspec_rules::flockwave::sio_02;

use self::session::Session;
use super::Shared;
use super::connection::{Protocol, Step};
use super::limits::{CLIENT_LIMIT, IDLE_TIME, REQUEST_LIMIT, SEND_LIMIT};
use super::outbox::{Outbox, Taken};
use super::reply::{Pending, Reply};
use super::seats::{Admission, Seats};
use super::statistics::Reason;

/// The maximum number of packets per poll response. Some clients accept only this many.
const PACKETS_AT_ONCE: usize = 16;

/// The maximum duration of a poll without packets. Pings are more frequent.
const POLL_LIMIT: Duration = Duration::from_secs(60);

/// The size of the buffer in which a WebSocket stores received bytes.
const READ_BUFFER: usize = 4 << 10;

/// All sessions, by id.
pub(super) struct Sessions {
    all: BTreeMap<String, Rc<Session>>,
    seats: Seats<String>,
}

impl Default for Sessions {
    fn default() -> Self {
        Self { all: BTreeMap::new(), seats: Seats::new(CLIENT_LIMIT, IDLE_TIME) }
    }
}

/// Sends pings, and ends sessions that didn't respond to them.
pub(super) fn tend(shared: &mut Shared) {
    let now = shared.now();
    let (alive, expired): (Vec<_>, Vec<_>) =
        shared.sessions.all.values().cloned().partition(|session| session.is_alive(now));
    for session in alive {
        session.ping_if_due(now);
    }
    for session in expired {
        session.end(shared);
    }
}

impl Sessions {
    /// Closes all sessions, including those of clients that joined no namespace.
    pub(super) fn end(&self) {
        for session in self.all.values() {
            session.close();
        }
    }

    fn remove(&mut self, sid: &String) {
        self.all.remove(sid);
        self.seats.remove(sid);
    }
}

/// Ends a session that gives way to a newcomer.
fn replace(shared: &mut Shared, sid: &String) {
    shared.statistics.count(Reason::Replaced);
    if let Some(session) = shared.sessions.all.get(sid).cloned() {
        session.dismiss(shared, Reason::Replaced);
    }
}

/// Opens a session. If there are too many, an idle session gives way.
fn open(shared: &mut Shared, revision: Revision) -> Option<Rc<Session>> {
    let now = shared.now();
    match shared.sessions.seats.admit(now) {
        Admission::Free => {}
        Admission::Evict(sid) => replace(shared, &sid),
        Admission::Refused => {
            shared.statistics.refused += 1;
            return None;
        }
    }
    let session = Session::open(shared, revision);
    shared.sessions.seats.insert(session.sid().clone(), now);
    shared.sessions.all.insert(session.sid().clone(), Rc::clone(&session));
    Some(session)
}

fn refused(reason: &str) -> Response {
    Response::refusal("400 Bad Request", reason)
}

/// The session of a request. If the request has no session id, a session is created.
fn session(shared: &mut Shared, request: &Request) -> Result<Rc<Session>, Response> {
    let revision = request.field("EIO").and_then(Revision::from_number);
    let revision = revision.ok_or_else(|| refused("EIO must be 3 or 4"))?;
    match request.field("sid") {
        Some(sid) => {
            let session = shared.sessions.all.get(sid).ok_or_else(|| refused("unknown session"))?;
            let is_same = session.revision() == revision;
            if is_same {
                Ok(Rc::clone(session))
            } else {
                Err(refused("the session was opened with a different EIO"))
            }
        }
        None if request.method == "GET" => open(shared, revision)
            .ok_or_else(|| Response::refusal("503 Service Unavailable", "too many sessions")),
        None => Err(refused("use GET to open a session")),
    }
}

/// Handles a long-polling request.
pub(super) fn by_polling(shared: &mut Shared, request: &Request) -> Reply {
    if request.field("transport") != Some("polling") {
        return Reply::Now(refused("transport must be polling or websocket"));
    }
    if request.field("j").is_some() {
        return Reply::Now(refused("JSONP isn't supported"));
    }
    if shared.has_bug(&sio_02::RULE) {
        return Reply::Now(refused("long polling isn't supported"));
    }
    let session = match session(shared, request) {
        Ok(session) => session,
        Err(response) => return Reply::Now(response),
    };
    if request.field("sid").is_some() {
        session.mark_used();
    }
    if session.is_upgraded() {
        return Reply::Now(refused("the session has been upgraded to a WebSocket"));
    }
    match request.method.as_str() {
        // Two concurrent polls would divide the packets between them.
        "GET" => match Poll::start(session, shared.clock.clone()) {
            Some(poll) => Reply::Later(Box::new(poll)),
            None => Reply::Now(refused("another poll of this session is pending")),
        },
        "POST" => Reply::Now(take(shared, &session, &request.body)),
        _ => {
            let refusal = Response::refusal("405 Method Not Allowed", "use GET or POST");
            Reply::Now(refusal.with("Allow", "GET, POST"))
        }
    }
}

/// A request that waits for packets. Dropping it allows the next poll.
struct Poll {
    session: Rc<Session>,
    clock: Clock,
    until: Instant,
}

impl Poll {
    /// Starts a poll, unless another poll of the session is pending.
    fn start(session: Rc<Session>, clock: Clock) -> Option<Self> {
        let now = clock.now();
        session.start_poll(now).then(|| Self { session, clock, until: now + POLL_LIMIT })
    }

    fn is_over(&self) -> bool {
        self.clock.now() >= self.until
    }
}

impl Pending for Poll {
    fn is_due(&self) -> bool {
        self.session.queue().is_ready() || self.is_over()
    }

    fn response(&mut self, _: &mut Shared) -> Option<Response> {
        let texts = match self.session.queue().take(PACKETS_AT_ONCE) {
            Taken::Texts(texts) => texts,
            Taken::Nothing if !self.is_over() => return None,
            Taken::Nothing => vec![Packet::new(Kind::Noop, "").to_text()],
            Taken::End => return Some(refused("the session has ended")),
        };
        let packets: Vec<Packet> = texts.iter().filter_map(|text| Packet::parse(text)).collect();
        let payload = encode(self.session.revision(), &packets);
        Some(Response::new("200 OK", "text/plain; charset=UTF-8", payload))
    }
}

impl Drop for Poll {
    fn drop(&mut self) {
        self.session.end_poll(self.clock.now());
    }
}

fn take(shared: &mut Shared, session: &Session, payload: &[u8]) -> Response {
    let packets = match decode(session.revision(), payload) {
        Ok(packets) => packets,
        Err(error) => return refused(&error),
    };
    for packet in packets {
        session.take(shared, packet);
    }
    Response::new("200 OK", "text/html", "ok")
}

/// Answers the request for an upgrade to a WebSocket. `rest` are the bytes after the request.
pub(super) fn over_web_socket(
    shared: &mut Shared,
    outbox: &Rc<Outbox>,
    request: &Request,
    rest: &[u8],
) -> Result<WebSocketClient, Response> {
    let key =
        request.header("sec-websocket-key").filter(|_| request.header("sec-websocket-version") == Some("13"));
    let key = key
        .filter(|_| request.field("transport") == Some("websocket"))
        .ok_or_else(|| refused("expected WebSocket version 13 and transport=websocket"))?;
    let session = session(shared, request)?;
    outbox.push(
        format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {}\r\n\r\n",
            derive_accept_key(key.as_bytes())
        )
        .as_bytes(),
    );
    if request.field("sid").is_none() {
        session.upgrade(outbox);
    }
    let config = WebSocketConfig::default()
        .read_buffer_size(READ_BUFFER)
        .max_message_size(Some(REQUEST_LIMIT))
        .max_frame_size(Some(REQUEST_LIMIT));
    let pipe = Pipe { received: Vec::new(), start: 0, outbox: Rc::clone(outbox) };
    let mut client = WebSocketClient {
        session,
        socket: WebSocket::from_raw_socket(pipe, Role::Server, Some(config)),
        incomplete: 0,
    };
    client.feed(rest);
    Ok(client)
}

/// The stream below a WebSocket: received bytes, and the queue of bytes to send.
struct Pipe {
    received: Vec<u8>,
    /// The number of bytes that were read.
    start: usize,
    outbox: Rc<Outbox>,
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = (&self.received[self.start..]).read(buffer)?;
        if length == 0 {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        self.start += length;
        Ok(length)
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.outbox.push(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A client over a WebSocket.
pub(super) struct WebSocketClient {
    session: Rc<Session>,
    socket: WebSocket<Pipe>,
    /// The number of bytes since the last complete message.
    incomplete: usize,
}

impl WebSocketClient {
    fn take(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>, text: &str) -> Step {
        let Some(packet) = Packet::parse(text) else { return Step::End };
        match (packet.kind, self.session.is_upgraded()) {
            (Kind::Ping, false) => {
                outbox.push_text(&Packet::new(Kind::Pong, packet.data).to_text());
                self.session.release_poll();
            }
            (Kind::Upgrade, false) => self.session.upgrade(outbox),
            (_, false) => return Step::End,
            (_, true) => {
                return Step::Handled { is_request: self.session.take(shared, packet) };
            }
        }
        Step::Handled { is_request: false }
    }
}

impl Protocol for WebSocketClient {
    fn feed(&mut self, bytes: &[u8]) {
        let pipe = self.socket.get_mut();
        pipe.received.drain(..pipe.start);
        pipe.start = 0;
        pipe.received.extend_from_slice(bytes);
        self.incomplete += bytes.len();
    }

    fn step(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>) -> Step {
        let message = match self.socket.read() {
            Err(Error::Io(error)) if is_silence(&error) => {
                // The WebSocket has read everything.
                let pipe = self.socket.get_mut();
                (pipe.received, pipe.start) = (Vec::new(), 0);
                return Step::Starved;
            }
            Err(_) => return Step::End,
            Ok(message) => message,
        };
        let pipe = self.socket.get_ref();
        self.incomplete = pipe.received.len() - pipe.start;
        match message {
            Message::Text(text) => self.take(shared, outbox, &text),
            Message::Close(_) => {
                // Sends the answer to the close frame.
                let _ = self.socket.flush();
                Step::End
            }
            _ => Step::Handled { is_request: false },
        }
    }

    fn has_rest(&self) -> bool {
        self.incomplete > 0
    }

    fn capacity(&self) -> usize {
        // The buffer of the WebSocket doesn't count, because each client has one.
        self.incomplete
    }

    fn idle_limit(&self) -> Option<Duration> {
        // A session that has been upgraded has its own pings.
        (!self.session.is_upgraded()).then_some(SEND_LIMIT)
    }

    fn dismiss(&mut self, shared: &mut Shared, reason: Reason) {
        self.session.dismiss(shared, reason);
    }

    fn end(&mut self, shared: &mut Shared) {
        if self.session.is_upgraded() {
            self.session.end(shared);
        }
    }
}
