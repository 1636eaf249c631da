//! Socket.IO: Engine.IO sessions over WebSocket and long polling, in revisions 3 and 4.

mod session;

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read, Write};
use std::iter;
use std::rc::Rc;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};
use uavspec_flockwave::transport::engine::{Kind, Packet, Revision, decode, encode};
use uavspec_flockwave::transport::http::{Request, Response};
use uavspec_model::net::is_silence;
use uavspec_rules::flockwave::sio_02;

use self::session::Session;
use super::Shared;
use super::connection::{Protocol, Step};
use super::limits::{CLIENT_LIMIT, DISCONNECTED, REFUSED, REPLACED, REQUEST_LIMIT, Reason};
use super::outbox::Outbox;
use super::seats::{Admission, admit};
use super::web::{Pending, Reply};

/// The maximum number of packets per poll response. Some clients accept only this many.
const PACKETS_AT_ONCE: usize = 16;

/// The maximum duration of a poll without packets. Pings are more frequent.
const POLL_LIMIT: Duration = Duration::from_secs(60);

/// The size of the buffer in which a WebSocket stores received bytes.
const READ_BUFFER: usize = 4 << 10;

/// All sessions, by id.
pub(super) type Sessions = BTreeMap<String, Rc<Session>>;

/// Sends pings, and ends sessions that have not responded to earlier ones.
pub(super) fn tend(shared: &mut Shared) {
    let now = shared.now();
    let sessions: Vec<Rc<Session>> = shared.sessions.values().cloned().collect();
    for session in sessions {
        if session.is_alive(now) {
            session.ping_if_due(now);
        } else {
            session.end(shared, DISCONNECTED);
        }
    }
}

/// Closes all sessions, including sessions of clients that joined no namespace.
pub(super) fn close(shared: &Shared) {
    for session in shared.sessions.values() {
        session.close();
    }
}

/// Opens a session. If there are too many, closes an idle session, or refuses the new one.
fn open(shared: &mut Shared, revision: Revision) -> Result<Rc<Session>, Response> {
    let seats = shared.sessions.values().map(|session| (session, session.seat.get()));
    match admit(seats, CLIENT_LIMIT, shared.now()) {
        Admission::Free => {}
        Admission::Evict(session) => {
            let session = Rc::clone(session);
            shared.count(REPLACED);
            session.end(shared, REPLACED);
        }
        Admission::Refused => {
            shared.count(REFUSED);
            return Err(Response::refusal("503 Service Unavailable", "too many sessions"));
        }
    }
    let session = Session::open(shared, revision);
    shared.sessions.insert(session.sid.clone(), Rc::clone(&session));
    Ok(session)
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
            let session = shared.sessions.get(sid).ok_or_else(|| refused("unknown session"))?;
            if session.revision != revision {
                return Err(refused("the session was opened with a different EIO"));
            }
            session.is_used.set(true);
            Ok(Rc::clone(session))
        }
        None if request.method == "GET" => open(shared, revision),
        None => Err(refused("use GET to open a session")),
    }
}

/// Handles a long-polling request.
pub(super) fn by_polling(shared: &mut Shared, request: &Request) -> Result<Reply, Response> {
    if request.field("transport") != Some("polling") {
        return Err(refused("transport must be polling or websocket"));
    }
    if request.field("j").is_some() {
        return Err(refused("JSONP isn't supported"));
    }
    if shared.has_bug(&sio_02::RULE) {
        return Err(refused("long polling isn't supported"));
    }
    let session = session(shared, request)?;
    if session.is_upgraded() {
        return Err(refused("the session has been upgraded to a WebSocket"));
    }
    match request.method.as_str() {
        "GET" if session.start_poll(shared.now()) => {
            Ok(Reply::Later(Box::new(Poll { session, until: shared.now() + POLL_LIMIT })))
        }
        // Two concurrent polls would divide the packets between them.
        "GET" => Err(refused("another poll of this session is pending")),
        "POST" => {
            for packet in decode(session.revision, &request.body).map_err(|error| refused(&error))? {
                session.take(shared, packet);
            }
            Ok(Reply::Now(Response::new("200 OK", "text/html", "ok")))
        }
        _ => {
            let refusal = Response::refusal("405 Method Not Allowed", "use GET or POST");
            Err(refusal.with("Allow", "GET, POST"))
        }
    }
}

/// A request that waits for packets.
struct Poll {
    session: Rc<Session>,
    until: Instant,
}

impl Pending for Poll {
    fn response(&mut self, shared: &mut Shared) -> Option<Response> {
        let queue = &self.session.queue;
        let texts = iter::from_fn(|| queue.take()).take(PACKETS_AT_ONCE);
        let mut packets: Vec<Packet> =
            texts.filter_map(|text| Packet::parse(std::str::from_utf8(&text).ok()?)).collect();
        if packets.is_empty() {
            if queue.is_closed() {
                return Some(refused("the session has ended"));
            }
            if shared.now() < self.until {
                return None;
            }
            packets.push(Packet::new(Kind::Noop, ""));
        }
        let payload = encode(self.session.revision, &packets);
        Some(Response::new("200 OK", "text/plain; charset=UTF-8", payload))
    }

    fn end(&mut self, shared: &mut Shared) {
        self.session.end_poll(shared.now());
    }
}

/// Answers the request for an upgrade to a WebSocket. `rest` are the bytes after the request.
pub(super) fn over_web_socket(
    shared: &mut Shared,
    outbox: &Rc<Outbox>,
    request: &Request,
    rest: &[u8],
) -> Result<WebSocketClient, Response> {
    let is_supported = request.header("sec-websocket-version") == Some("13")
        && request.field("transport") == Some("websocket");
    let key = request.header("sec-websocket-key").filter(|_| is_supported);
    let key = key.ok_or_else(|| refused("expected WebSocket version 13 and transport=websocket"))?;
    let session = session(shared, request)?;
    outbox.push(format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {}\r\n\r\n",
        derive_accept_key(key.as_bytes())
    ));
    if request.field("sid").is_none() {
        session.upgrade(outbox);
    }
    let config = WebSocketConfig::default()
        .read_buffer_size(READ_BUFFER)
        .max_message_size(Some(REQUEST_LIMIT))
        .max_frame_size(Some(REQUEST_LIMIT));
    let pipe = Pipe { received: VecDeque::new(), outbox: Rc::clone(outbox) };
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
    received: VecDeque<u8>,
    outbox: Rc<Outbox>,
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.received.is_empty() {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        self.received.read(buffer)
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
                outbox.push_text(Packet::new(Kind::Pong, packet.data).to_text());
                // The client can switch to the WebSocket after the end of the poll.
                self.session.push(Kind::Noop, "");
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
        self.socket.get_mut().received.extend(bytes);
        self.incomplete += bytes.len();
    }

    fn step(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>) -> Step {
        // The session may have ended before it moved to this WebSocket.
        if !self.session.is_upgraded() && !shared.sessions.contains_key(&self.session.sid) {
            return Step::End;
        }
        let message = match self.socket.read() {
            Err(Error::Io(error)) if is_silence(&error) => {
                // The WebSocket has read everything.
                self.socket.get_mut().received = VecDeque::new();
                return Step::Starved;
            }
            Err(_) => return Step::End,
            Ok(message) => message,
        };
        self.incomplete = self.socket.get_ref().received.len();
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

    fn unfinished(&self) -> usize {
        // The buffer of the WebSocket doesn't count, because each client has one.
        self.incomplete
    }

    fn end(&mut self, shared: &mut Shared, reason: Reason) {
        if reason.is_some() || self.session.is_upgraded() {
            self.session.end(shared, reason);
        }
    }
}
