//! Socket.IO: sessions of Engine.IO, over a WebSocket and by long polling, in both revisions.

mod session;

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use self::session::Session;
use super::{POLL_INTERVAL, SEND_LIMIT, Shared};
use crate::flockwave::transport::MESSAGE_LIMIT;
use crate::flockwave::transport::engine::{Kind, Packet, Revision, decode, encode};
use crate::flockwave::transport::http::{Connection, Request, Response, is_silence};
use crate::rules::flockwave::sio_02;
use crate::serve::outbox::Taken;

/// How many sessions there may be at a time.
const SESSION_LIMIT: usize = 1024;

/// How many packets a response to a poll has: some clients take no more.
const PACKETS_AT_ONCE: usize = 16;

/// How long a poll stays open where nothing happens. Pings come more often.
const POLL_LIMIT: Duration = Duration::from_secs(60);

/// How long a WebSocket is read from before it is seen whether something is to be sent.
const READ_TIMEOUT: Duration = Duration::from_millis(10);

/// All sessions, by their ids.
#[derive(Default)]
pub(super) struct Sessions(Mutex<BTreeMap<String, Arc<Session>>>);

impl Sessions {
    fn all(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Session>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn find(&self, sid: &str) -> Option<Arc<Session>> {
        self.all().get(sid).cloned()
    }

    /// Asks for signs of life, and drops sessions that gave none.
    pub(super) fn tend(&self, shared: &Shared) {
        let mut gone = Vec::new();
        self.all().retain(|_, session| {
            let is_there = session.tend();
            if !is_there {
                gone.push(Arc::clone(session));
            }
            is_there
        });
        for session in gone {
            session.end(shared);
        }
    }

    /// Lets nothing more be sent, also to clients that joined nothing.
    pub(super) fn end(&self) {
        for session in self.all().values() {
            session.outbox().close();
        }
    }

    fn open(&self, shared: &Shared, revision: Revision) -> Option<(String, Arc<Session>)> {
        if self.all().len() >= SESSION_LIMIT {
            return None;
        }
        let (sid, session) = Session::open(shared, revision);
        self.all().insert(sid.clone(), Arc::clone(&session));
        Some((sid, session))
    }
}

fn refused(reason: &str) -> Response {
    Response::refusal("400 Bad Request", reason)
}

/// What a request is about: a session that is there, or a new one.
fn session(shared: &Shared, request: &Request) -> Result<Arc<Session>, Response> {
    let revision = request.field("EIO").and_then(Revision::from_number);
    let revision = revision.ok_or_else(|| refused("EIO must be 3 or 4"))?;
    match request.field("sid") {
        Some(sid) => {
            let session = shared.sessions.find(sid).ok_or_else(|| refused("there is no such session"))?;
            let is_same = session.revision() == revision;
            if is_same { Ok(session) } else { Err(refused("the session is of another revision")) }
        }
        None if request.method == "GET" => {
            let opened = shared.sessions.open(shared, revision);
            opened
                .map(|(_, session)| session)
                .ok_or_else(|| Response::refusal("503 Service Unavailable", "there are too many sessions"))
        }
        None => Err(refused("a session is opened with GET")),
    }
}

/// Answers a request of long polling.
pub(super) fn by_polling(shared: &Shared, request: &Request) -> Response {
    if request.field("transport") != Some("polling") {
        return refused("transport must be polling or websocket");
    }
    if request.field("j").is_some() {
        return refused("JSONP isn't served");
    }
    if shared.has_bug(&sio_02::RULE) {
        return refused("long polling isn't served");
    }
    let session = match session(shared, request) {
        Ok(session) => session,
        Err(response) => return response,
    };
    if session.is_upgraded() {
        return refused("the session has moved to a WebSocket");
    }
    match request.method.as_str() {
        "GET" => poll(&session),
        "POST" => take(shared, &session, &request.body),
        _ => Response::refusal("405 Method Not Allowed", "there are GET and POST").with("Allow", "GET, POST"),
    }
}

fn poll(session: &Session) -> Response {
    let Some(_polling) = session.start_poll() else {
        // Two at once would take packets from each other.
        return refused("a poll of this session is open");
    };
    let texts = match session.outbox().take(PACKETS_AT_ONCE, Instant::now() + POLL_LIMIT) {
        Taken::Texts(texts) => texts,
        Taken::Nothing => vec![Packet::new(Kind::Noop, "").to_text()],
        Taken::End => return refused("the session has ended"),
    };
    let packets: Vec<Packet> = texts.iter().filter_map(|text| Packet::parse(text)).collect();
    Response::new("200 OK", "text/plain; charset=UTF-8", encode(session.revision(), &packets))
}

fn take(shared: &Shared, session: &Session, payload: &[u8]) -> Response {
    let packets = match decode(session.revision(), payload) {
        Ok(packets) => packets,
        Err(error) => return refused(&error),
    };
    for packet in packets {
        session.take(shared, packet);
    }
    Response::new("200 OK", "text/html", "ok")
}

/// Serves a connection that becomes a WebSocket.
pub(super) fn over_web_socket(
    shared: &Shared,
    mut connection: Connection,
    request: &Request,
) -> io::Result<()> {
    let key =
        request.header("sec-websocket-key").filter(|_| request.header("sec-websocket-version") == Some("13"));
    let session = match key {
        Some(_) if request.field("transport") == Some("websocket") => session(shared, request),
        _ => Err(refused("no WebSocket of version 13 with transport=websocket")),
    };
    let (key, session) = match (key, session) {
        (Some(key), Ok(session)) => (key, session),
        (_, Err(response)) => return connection.respond(None, &response).map(|_| ()),
        (None, Ok(_)) => return Ok(()),
    };
    let accept = derive_accept_key(key.as_bytes());
    let (mut stream, rest) = connection.into_stream();
    stream.write_all(
        format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {accept}\r\n\r\n"
        )
        .as_bytes(),
    )?;
    stream.set_read_timeout(Some(READ_TIMEOUT))?;
    stream.set_write_timeout(Some(SEND_LIMIT))?;
    let limit = MESSAGE_LIMIT + 1024;
    let config = WebSocketConfig::default().max_message_size(Some(limit)).max_frame_size(Some(limit));
    let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
    if request.field("sid").is_none() {
        session.upgrade();
    }
    let ending = serve_connection(shared, &session, socket);
    if session.is_upgraded() {
        session.end(shared);
    }
    match ending {
        Err(Error::Io(error)) => Err(error),
        _ => Ok(()),
    }
}

/// Reads and writes in turn, until either side ends.
fn serve_connection(
    shared: &Shared,
    session: &Session,
    mut socket: WebSocket<std::net::TcpStream>,
) -> Result<(), Error> {
    let probed = Instant::now() + SEND_LIMIT;
    loop {
        if session.is_upgraded() {
            match session.outbox().take(PACKETS_AT_ONCE, Instant::now()) {
                Taken::Texts(texts) => {
                    for text in texts {
                        socket.send(Message::text(text))?;
                    }
                    continue_reading(&mut socket, Duration::from_millis(1))?;
                }
                Taken::Nothing => continue_reading(&mut socket, READ_TIMEOUT)?,
                Taken::End => {
                    socket.close(None)?;
                    return farewell(&mut socket);
                }
            }
        } else if Instant::now() > probed || shared.is_ending() {
            return Ok(());
        }
        let text = match socket.read() {
            Ok(Message::Text(text)) => text,
            // It has been answered; the client closes the connection.
            Ok(Message::Close(_)) => return Ok(()),
            Ok(_) => continue,
            Err(Error::Io(error)) if is_silence(&error) => continue,
            Err(error) => return Err(error),
        };
        let Some(packet) = Packet::parse(&text) else { return Ok(()) };
        match (packet.kind, session.is_upgraded()) {
            (Kind::Ping, false) => {
                socket.send(Message::text(Packet::new(Kind::Pong, packet.data).to_text()))?;
                session.release_poll();
            }
            (Kind::Upgrade, false) => session.upgrade(),
            (_, false) => return Ok(()),
            (_, true) => session.take(shared, packet),
        }
    }
}

/// How long the next reading may wait.
fn continue_reading(socket: &mut WebSocket<std::net::TcpStream>, wait: Duration) -> Result<(), Error> {
    Ok(socket.get_ref().set_read_timeout(Some(wait))?)
}

/// Waits for the client to close as well, but not for long.
fn farewell(socket: &mut WebSocket<std::net::TcpStream>) -> Result<(), Error> {
    continue_reading(socket, POLL_INTERVAL)?;
    let until = Instant::now() + POLL_INTERVAL * 5;
    while Instant::now() < until {
        match socket.read() {
            Ok(_) => {}
            Err(Error::Io(error)) if is_silence(&error) => {}
            Err(Error::ConnectionClosed) => return Ok(()),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
