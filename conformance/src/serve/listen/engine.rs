//! Socket.IO: Engine.IO sessions over WebSocket and long polling, in revisions 3 and 4.

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

/// The maximum number of concurrent sessions.
const SESSION_LIMIT: usize = 1024;

/// The maximum number of packets per poll response. Some clients accept only this many.
const PACKETS_AT_ONCE: usize = 16;

/// The maximum duration of a poll without packets. Pings are more frequent.
const POLL_LIMIT: Duration = Duration::from_secs(60);

/// The read timeout of a WebSocket, after which queued packets are sent.
const READ_TIMEOUT: Duration = Duration::from_millis(10);

/// All sessions, by id.
#[derive(Default)]
pub(super) struct Sessions(Mutex<BTreeMap<String, Arc<Session>>>);

impl Sessions {
    fn all(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Session>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn find(&self, sid: &str) -> Option<Arc<Session>> {
        self.all().get(sid).cloned()
    }

    /// Sends pings, and ends sessions that didn't respond to them.
    pub(super) fn tend(&self, shared: &Shared) {
        let mut expired = Vec::new();
        self.all().retain(|_, session| {
            let is_alive = session.tend();
            if !is_alive {
                expired.push(Arc::clone(session));
            }
            is_alive
        });
        for session in expired {
            session.end(shared);
        }
    }

    /// Closes all outboxes, including those of clients that joined no namespace.
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

/// The session of a request. If the request has no session id, a session is created.
fn session(shared: &Shared, request: &Request) -> Result<Arc<Session>, Response> {
    let revision = request.field("EIO").and_then(Revision::from_number);
    let revision = revision.ok_or_else(|| refused("EIO must be 3 or 4"))?;
    match request.field("sid") {
        Some(sid) => {
            let session = shared.sessions.find(sid).ok_or_else(|| refused("unknown session"))?;
            let is_same = session.revision() == revision;
            if is_same { Ok(session) } else { Err(refused("the session was opened with a different EIO")) }
        }
        None if request.method == "GET" => {
            let opened = shared.sessions.open(shared, revision);
            opened
                .map(|(_, session)| session)
                .ok_or_else(|| Response::refusal("503 Service Unavailable", "too many sessions"))
        }
        None => Err(refused("use GET to open a session")),
    }
}

/// Answers a long-polling request.
pub(super) fn by_polling(shared: &Shared, request: &Request) -> Response {
    if request.field("transport") != Some("polling") {
        return refused("transport must be polling or websocket");
    }
    if request.field("j").is_some() {
        return refused("JSONP isn't supported");
    }
    if shared.has_bug(&sio_02::RULE) {
        return refused("long polling isn't supported");
    }
    let session = match session(shared, request) {
        Ok(session) => session,
        Err(response) => return response,
    };
    if session.is_upgraded() {
        return refused("the session has been upgraded to a WebSocket");
    }
    match request.method.as_str() {
        "GET" => poll(&session),
        "POST" => take(shared, &session, &request.body),
        _ => Response::refusal("405 Method Not Allowed", "use GET or POST").with("Allow", "GET, POST"),
    }
}

fn poll(session: &Session) -> Response {
    let Some(_polling) = session.start_poll() else {
        // Two concurrent polls would divide the packets between them.
        return refused("another poll of this session is pending");
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

/// Serves a connection after its upgrade to a WebSocket.
pub(super) fn over_web_socket(
    shared: &Shared,
    mut connection: Connection,
    request: &Request,
) -> io::Result<()> {
    let key =
        request.header("sec-websocket-key").filter(|_| request.header("sec-websocket-version") == Some("13"));
    let session = match key {
        Some(_) if request.field("transport") == Some("websocket") => session(shared, request),
        _ => Err(refused("expected WebSocket version 13 and transport=websocket")),
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

/// Reads and writes alternately, until either side ends.
fn serve_connection(
    shared: &Shared,
    session: &Session,
    mut socket: WebSocket<std::net::TcpStream>,
) -> Result<(), Error> {
    let upgrade_deadline = Instant::now() + SEND_LIMIT;
    loop {
        if session.is_upgraded() {
            match session.outbox().take(PACKETS_AT_ONCE, Instant::now()) {
                Taken::Texts(texts) => {
                    for text in texts {
                        socket.send(Message::text(text))?;
                    }
                    set_read_timeout(&mut socket, Duration::from_millis(1))?;
                }
                Taken::Nothing => set_read_timeout(&mut socket, READ_TIMEOUT)?,
                Taken::End => {
                    socket.close(None)?;
                    return await_close(&mut socket);
                }
            }
        } else if Instant::now() > upgrade_deadline || shared.is_ending() {
            return Ok(());
        }
        let text = match socket.read() {
            Ok(Message::Text(text)) => text,
            // The library has answered the close frame; the client closes the connection.
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

/// Sets the timeout of the next read.
fn set_read_timeout(socket: &mut WebSocket<std::net::TcpStream>, wait: Duration) -> Result<(), Error> {
    Ok(socket.get_ref().set_read_timeout(Some(wait))?)
}

/// Waits briefly for the client to close the connection as well.
fn await_close(socket: &mut WebSocket<std::net::TcpStream>) -> Result<(), Error> {
    set_read_timeout(socket, POLL_INTERVAL)?;
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
