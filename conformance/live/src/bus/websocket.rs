//! The WebSocket connection of the Foxglove and rosbridge clients.
//!
//! [`receive`] reads the socket. There is no thread and no queue, so memory is bounded by one message. A slow reader slows
//! down the server, which then drops messages. Neither protocol numbers its messages, so only losses that the server
//! reports are known.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use tungstenite::client::IntoClientRequest as _;
use tungstenite::error::ProtocolError;
use tungstenite::handshake::client::Request;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Bytes, Error, HandshakeError, Message, WebSocket};
use uavspec_model::clock::Clock;
use uavspec_model::json::Tree;
use uavspec_model::limits::MAX_NAME;
use uavspec_model::net::{Address, Stream, is_silence};
use uavspec_model::text::start_of;
use uavspec_model::{Endpoint, EndpointKind};

use super::Event;
use super::problems::Problems;
use crate::limits::MAX_MESSAGE;

/// The maximum time until the connection is open.
pub(super) const CONNECT_LIMIT: Duration = Duration::from_secs(5);

/// The maximum length of an excerpt, in characters.
const MAX_EXCERPT: usize = 200;

/// The time without a message after which a ping is sent.
const PING_INTERVAL: Duration = Duration::from_secs(10);

/// The maximum time until the server answers a ping.
const PONG_LIMIT: Duration = Duration::from_secs(20);

/// The maximum time for which sending may block.
const SEND_LIMIT: Duration = Duration::from_secs(2);

/// The maximum time for which sending a ping or a close frame may block.
const PING_LIMIT: Duration = Duration::from_millis(100);

/// The minimum time to wait. It ensures that data that has already arrived is read, even if the deadline has passed.
const MIN_WAIT: Duration = Duration::from_millis(1);

/// The kind of server that a client expects.
pub(super) struct Service {
    /// A program that provides this service, with its usual port.
    pub(super) example: &'static str,
    /// The subprotocols, starting with the preferred one. Empty if there are none.
    pub(super) subprotocols: &'static str,
}

/// The parts of a client that depend on the protocol.
pub(super) trait Protocol {
    /// The connection.
    fn link(&mut self) -> &mut Link;

    /// Handles a text message. The error describes the reason why it can't be read.
    fn text(&mut self, text: &str) -> Result<(), String>;

    /// Handles a binary message. The error describes the reason why it can't be read.
    fn binary(&mut self, bytes: &[u8]) -> Result<(), String>;

    /// Sends the requests that are due. Returns the time at which the next request is due.
    fn poll(&mut self) -> Option<Instant> {
        None
    }
}

/// The next event of a client, or `None` if there is none before the deadline.
pub(super) fn receive(client: &mut impl Protocol, deadline: Instant) -> Option<Event> {
    while client.link().events.is_empty() && step(client, deadline) {}
    client.link().events.pop_front()
}

/// Handles at most one message. Returns false if the deadline has passed or the connection has ended.
pub(super) fn step(client: &mut impl Protocol, deadline: Instant) -> bool {
    let known = client.link().events.len();
    let due = client.poll().map_or(deadline, |due| due.min(deadline));
    if client.link().events.len() > known {
        return true;
    }
    let handled = match client.link().next(due) {
        Some(Message::Text(text)) => client.text(&text),
        Some(Message::Binary(bytes)) => client.binary(&bytes),
        _ => Ok(()),
    };
    if let Err(problem) = handled {
        client.link().unreadable(problem);
    }
    // Many messages without an event must not block the caller.
    !client.link().is_closed && Clock::real().now() < deadline
}

/// A WebSocket connection, and the events that the caller hasn't received yet.
pub(super) struct Link {
    socket: WebSocket<Stream>,
    heartbeat: Heartbeat,
    events: VecDeque<Event>,
    problems: Problems,
    is_closed: bool,
}

impl Link {
    /// Opens a connection. The error describes the problem.
    pub(super) fn open(service: &Service, address: &Address, until: Instant) -> Result<Self, String> {
        let stream = Stream::open(address, None, until)
            .map_err(|error| format!("{error}. Start a server such as {}", service.example))?;
        let request = request(service, address).map_err(|error| error.to_string())?;
        let opened = tungstenite::client::client_with_config(request, stream, Some(config()));
        let (socket, _) = opened.map_err(|error| match error {
            HandshakeError::Interrupted(_) => explain(service, None),
            HandshakeError::Failure(error) => explain(service, Some(&error)),
        })?;
        let heartbeat = Heartbeat::new(Clock::real().now());
        Ok(Self {
            socket,
            heartbeat,
            events: VecDeque::new(),
            problems: Problems::default(),
            is_closed: false,
        })
    }

    /// Adds an event.
    pub(super) fn push(&mut self, event: Event) {
        self.events.push_back(event);
    }

    /// Reports a remark, unless it has already been reported or there are too many problems.
    pub(super) fn problem(&mut self, text: String) {
        self.events.extend(self.problems.remark(text));
    }

    /// Reports data that isn't received or can't be read, unless it has already been reported or there are too many
    /// problems.
    pub(super) fn unreadable(&mut self, text: String) {
        self.events.extend(self.problems.unreadable(text));
    }

    /// The reason for the end of the connection. `None` if it is open.
    pub(super) fn closed(&self) -> Option<String> {
        self.events.iter().find_map(|event| match event {
            Event::Closed(reason) => Some(reason.clone()),
            _ => None,
        })
    }

    /// Sends a request. Closes the connection if the server doesn't read it.
    pub(super) fn request(&mut self, request: &serde_json::Value) -> Result<(), String> {
        let sent = self.send(Message::text(request.to_string()));
        sent.inspect_err(|problem| self.close(problem.clone()))
    }

    /// Sends a message. The error describes the problem.
    pub(super) fn send(&mut self, message: Message) -> Result<(), String> {
        if self.is_closed {
            return Err("the connection is closed".to_owned());
        }
        self.socket.get_mut().set_deadline(Clock::real().now() + SEND_LIMIT);
        self.socket.send(message).map_err(|error| format!("can't send: {error}"))
    }

    fn close(&mut self, reason: String) {
        if !self.is_closed {
            self.is_closed = true;
            self.push(Event::Closed(reason));
        }
    }

    /// The next message. `None` if none arrives in time, or if the connection is closed.
    fn next(&mut self, until: Instant) -> Option<Message> {
        if self.is_closed {
            return None;
        }
        let now = Clock::real().now();
        if self.heartbeat.is_ping_due(now) {
            self.ping();
        }
        self.socket.get_mut().set_deadline(until.min(self.heartbeat.next()).max(now + MIN_WAIT));
        match self.socket.read() {
            Ok(Message::Close(frame)) => {
                let reason = frame.map_or_else(String::new, |frame| {
                    format!(": code {}, {:?}", u16::from(frame.code), excerpt(&frame.reason))
                });
                self.close(format!("the server closed the connection{reason}"));
            }
            Ok(message) => {
                self.heartbeat = Heartbeat::new(Clock::real().now());
                return Some(message);
            }
            Err(Error::Io(error)) if is_silence(&error) => {
                if self.heartbeat.is_dead(Clock::real().now()) {
                    self.close(format!("the server didn't answer a ping within {PONG_LIMIT:?}"));
                }
            }
            Err(error) => self.close(ended(&error)),
        }
        None
    }

    /// Sends a ping. If sending blocks, the rest of the ping is sent later.
    fn ping(&mut self) {
        self.socket.get_mut().set_deadline(Clock::real().now() + PING_LIMIT);
        match self.socket.send(Message::Ping(Bytes::new())) {
            Err(Error::Io(error)) if is_silence(&error) => {}
            Err(error) => self.close(ended(&error)),
            Ok(()) => {}
        }
    }
}

impl Drop for Link {
    /// Closes the connection with a close frame, because servers otherwise log a warning.
    fn drop(&mut self) {
        if !self.is_closed {
            self.socket.get_mut().set_deadline(Clock::real().now() + PING_LIMIT);
            let _ = self.socket.close(None);
            let _ = self.socket.flush();
        }
    }
}

/// The times of pings.
struct Heartbeat {
    /// The time of the last message.
    heard: Instant,
    /// The time of the ping that was sent since that message.
    pinged: Option<Instant>,
}

impl Heartbeat {
    /// The state after a message at this time.
    fn new(heard: Instant) -> Self {
        Self { heard, pinged: None }
    }

    /// True if a ping must be sent now. If so, counts the ping as sent.
    fn is_ping_due(&mut self, now: Instant) -> bool {
        let is_due = self.pinged.is_none() && now >= self.next();
        if is_due {
            self.pinged = Some(now);
        }
        is_due
    }

    /// The time at which the next ping is due. If a ping is pending, the deadline for its answer.
    fn next(&self) -> Instant {
        self.pinged.map_or(self.heard + PING_INTERVAL, |pinged| pinged + PONG_LIMIT)
    }

    /// True if a ping wasn't answered in time.
    fn is_dead(&self, now: Instant) -> bool {
        self.pinged.is_some() && now >= self.next()
    }
}

fn request(service: &Service, address: &Address) -> Result<Request, Error> {
    let mut request = format!("ws://{address}/").into_client_request()?;
    if !service.subprotocols.is_empty() {
        let value = HeaderValue::from_static(service.subprotocols);
        request.headers_mut().insert("Sec-WebSocket-Protocol", value);
    }
    Ok(request)
}

fn config() -> WebSocketConfig {
    // The header of a message adds only a few bytes.
    let limit = MAX_MESSAGE + 1024;
    let config = WebSocketConfig::default().max_message_size(Some(limit)).max_frame_size(Some(limit));
    config.max_write_buffer_size(2 * limit)
}

/// The cause of a failed handshake. `error` is `None` if the server didn't respond.
fn explain(service: &Service, error: Option<&Error>) -> String {
    let Service { example, subprotocols } = service;
    let found = match error {
        Some(Error::Http(response)) => format!("HTTP status {}", response.status().as_u16()),
        Some(Error::Protocol(ProtocolError::SecWebSocketSubProtocolError(_))) => {
            format!("a WebSocket server that supports none of the subprotocols {subprotocols}")
        }
        Some(Error::Io(error)) if !is_silence(error) => error.to_string(),
        None | Some(Error::Io(_)) => "no answer within the time limit".to_owned(),
        Some(error) => error.to_string(),
    };
    format!("expected a WebSocket server such as {example}, found {found}")
}

/// The cause of the end of a connection.
fn ended(error: &Error) -> String {
    match error {
        Error::ConnectionClosed
        | Error::AlreadyClosed
        | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake) => {
            "the server closed the connection".to_owned()
        }
        Error::Io(error) if error.kind() == io::ErrorKind::ConnectionReset => {
            "the server reset the connection".to_owned()
        }
        Error::Capacity(_) => {
            let limit = MAX_MESSAGE >> 20;
            format!("received a message of more than {limit} MiB: select other topics with --topics")
        }
        error => format!("the connection failed: {error}"),
    }
}

/// The start of a text from the server.
pub(super) fn excerpt(text: &str) -> Cow<'_, str> {
    start_of(text, MAX_EXCERPT)
}

/// Checks the length of a name. The name of a topic must not be empty.
pub(super) fn check_name(kind: &str, name: &str) -> Result<(), String> {
    if name.len() > MAX_NAME || (name.is_empty() && kind == "topic") {
        let length = name.len();
        return Err(format!(
            "expected a {kind} of 1 to {MAX_NAME} bytes, found {length} bytes: {:?}",
            excerpt(name)
        ));
    }
    Ok(())
}

/// The event for a topic that a server lists: a publisher with an unknown node and an unknown quality of service.
pub(super) fn publisher(id: String, topic: &str, type_name: &str) -> Event {
    Event::Endpoint(Endpoint {
        id,
        kind: EndpointKind::Publisher,
        node: None,
        topic: topic.to_owned(),
        type_name: type_name.to_owned(),
        type_hash: None,
        qos: None,
        is_matched_by_qos: false,
    })
}

/// A string in a JSON object.
pub(super) fn string<'t>(object: &'t Tree<'_>, key: &str) -> Result<&'t str, String> {
    member(object, key, "a string", |value| value.as_str())
}

/// An array in a JSON object.
pub(super) fn list<'t, 'a>(object: &'t Tree<'a>, key: &str) -> Result<&'t [Tree<'a>], String> {
    member(object, key, "an array", |value| match value {
        Tree::List(values) => Some(&**values),
        _ => None,
    })
}

/// A member of a JSON object. `read` returns `None` if the value doesn't have the expected type.
pub(super) fn member<'t, 'a, T>(
    object: &'t Tree<'a>,
    key: &str,
    expected: &str,
    read: impl Fn(&'t Tree<'a>) -> Option<T>,
) -> Result<T, String> {
    let value = object.get(key).ok_or_else(|| format!("the member `{key}` is missing"))?;
    read(value).ok_or_else(|| format!("`{key}`: expected {expected}, found {value}"))
}

#[cfg(test)]
pub(super) mod tests;
