//! Socket.IO over WebSocket.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use tungstenite::client::IntoClientRequest as _;
use tungstenite::error::ProtocolError;
use tungstenite::handshake::client::Request;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};
use uavspec_model::clock::Clock;
use uavspec_model::net::{Stream, is_silence};

use super::http::{not_http, tls_hint};
use super::status::{Refusal, redirected, too_many_redirects};
use super::target::Target;
use super::{Client, Received, invalid, text_of, timed_out};
use crate::limits::REDIRECT_LIMIT;
use crate::transport::access::Access;
use crate::transport::client::polling::{Heartbeat, Opening, Step, step};
use crate::transport::endpoint::ServerAddress;
use crate::transport::engine::{Kind, Packet, Revision};
use crate::transport::{MESSAGE_LIMIT, SOCKET_IO_PATH, socketio};

/// The maximum time that sending may block.
const SEND_LIMIT: Duration = Duration::from_secs(30);

/// The maximum time that sending a ping or a pong may block. The rest is sent later.
const PING_LIMIT: Duration = Duration::from_millis(100);

pub(super) struct WebSocketClient {
    socket: WebSocket<Stream>,
    heartbeat: Heartbeat,
    /// Packets that arrived during the handshake.
    early: VecDeque<Packet>,
}

impl WebSocketClient {
    pub(super) fn connect(
        address: &ServerAddress,
        revision: Revision,
        access: &Access,
        until: Instant,
    ) -> io::Result<Self> {
        let number = revision.engine_io();
        let target = Target::new(address, format!("{SOCKET_IO_PATH}?EIO={number}&transport=websocket"));
        let socket = open(target, access, until)?;
        let heartbeat = Heartbeat::new(revision);
        let mut client = Self { socket, heartbeat, early: VecDeque::new() };
        let mut opening = Opening::new(revision);
        while !opening.is_done() {
            let packet = client.packet(until).map_err(|error| match error.kind() {
                io::ErrorKind::TimedOut => timed_out("timed out: the server didn't open a Socket.IO session"),
                _ => error,
            })?;
            let Some(packet) = packet else {
                return Err(invalid("the server closed the connection during the handshake"));
            };
            if let Some(answer) = opening.take(&packet, &mut client.heartbeat)? {
                client.send_packet(&answer, left(until)?)?;
            }
        }
        client.early = opening.early;
        Ok(client)
    }

    fn send_packet(&mut self, packet: &Packet, limit: Duration) -> io::Result<()> {
        self.socket.get_mut().set_deadline(Clock::real().now() + limit);
        self.socket.send(Message::text(packet.to_text())).map_err(to_io)
    }

    /// Sends a ping or a pong.
    fn ping(&mut self, packet: &Packet) -> io::Result<()> {
        match self.send_packet(packet, PING_LIMIT) {
            Err(error) if is_silence(&error) => Ok(()),
            sent => sent,
        }
    }

    /// The next packet. `None` at the end of the connection.
    fn packet(&mut self, until: Instant) -> io::Result<Option<Packet>> {
        if let Some(packet) = self.early.pop_front() {
            return Ok(Some(packet));
        }
        loop {
            left(until)?;
            self.socket.get_mut().set_deadline(until);
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let packet = Packet::parse(&text)
                        .ok_or_else(|| invalid("received a packet of an unknown kind"))?;
                    return Ok(Some(packet));
                }
                Ok(Message::Binary(_)) => return Err(invalid("received a binary packet")),
                Ok(Message::Close(_))
                | Err(
                    Error::ConnectionClosed
                    | Error::AlreadyClosed
                    | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake),
                ) => return Ok(None),
                Ok(_) => {}
                Err(Error::Io(error)) if is_silence(&error) => {}
                Err(error) => return Err(to_io(error)),
            }
        }
    }
}

impl Client for WebSocketClient {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        self.send_raw(socketio::message(text_of(message)?).as_bytes())
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.send_packet(&Packet::new(Kind::Message, text_of(bytes)?), SEND_LIMIT)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            if let Some(ping) = self.heartbeat.due() {
                self.ping(&ping)?;
            }
            let packet = match self.packet(self.heartbeat.next().min(until)) {
                Ok(Some(packet)) => packet,
                Ok(None) => return Ok(Received::End),
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                    if Clock::real().now() >= until {
                        return Ok(Received::Silence);
                    }
                    continue;
                }
                Err(error) => return Err(error),
            };
            match step(packet) {
                Step::Received(received) => return Ok(received),
                Step::Answer(answer) => self.ping(&answer)?,
                Step::Nothing => {}
            }
        }
    }
}

/// Opens a WebSocket. Follows redirects on the same host.
fn open(mut target: Target, access: &Access, until: Instant) -> io::Result<WebSocket<Stream>> {
    for _ in 0..=REDIRECT_LIMIT {
        let trust = access.trust(target.address.is_encrypted);
        let stream = Stream::open(&target.address.address(), trust, until)?;
        let handshake =
            tungstenite::client::client_with_config(request(&target, access)?, stream, Some(config()));
        let response = match handshake {
            Ok((socket, _)) => return Ok(socket),
            Err(HandshakeError::Failure(Error::Http(response))) => response,
            Err(HandshakeError::Failure(Error::Io(error))) if !is_silence(&error) => return Err(error),
            Err(HandshakeError::Failure(Error::Io(_)) | HandshakeError::Interrupted(_)) => {
                return Err(timed_out("timed out: no WebSocket handshake"));
            }
            Err(HandshakeError::Failure(Error::Protocol(ProtocolError::HandshakeIncomplete))) => {
                return Err(invalid(format!(
                    "the server closed the connection during the WebSocket handshake{}",
                    tls_hint(&target)
                )));
            }
            Err(HandshakeError::Failure(Error::Protocol(error))) => return Err(not_http(&target, &error)),
            Err(HandshakeError::Failure(error)) => return Err(to_io(error)),
        };
        let (status, headers) = (response.status(), response.headers());
        target = redirected(&target, status, headers)?.ok_or_else(|| {
            let body = response.body().as_deref().unwrap_or_default();
            Refusal { target: &target, status, headers, body, access }.error()
        })?;
    }
    Err(too_many_redirects(&target))
}

/// The request that opens a WebSocket.
fn request(target: &Target, access: &Access) -> io::Result<Request> {
    let mut request = target.web_socket_url().into_client_request().map_err(to_io)?;
    if let Some(authorization) = access.authorization() {
        let value = HeaderValue::from_str(&authorization).map_err(io::Error::other)?;
        request.headers_mut().insert("Authorization", value);
    }
    Ok(request)
}

fn config() -> WebSocketConfig {
    // The packet adds only a few bytes to the message.
    let limit = MESSAGE_LIMIT + 1024;
    WebSocketConfig::default().max_message_size(Some(limit)).max_frame_size(Some(limit))
}

fn left(until: Instant) -> io::Result<Duration> {
    let left = Clock::real().left(until);
    if left.is_zero() { Err(timed_out("timed out: no packet")) } else { Ok(left) }
}

fn to_io(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => invalid(other.to_string()),
    }
}
