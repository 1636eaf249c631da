//! Socket.IO over WebSocket.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::client::IntoClientRequest as _;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

use super::{Client, Received, invalid, text_of, timed_out};
use crate::flockwave::transport::client::polling::{Heartbeat, Opening, Step, step};
use crate::flockwave::transport::engine::{Kind, Packet, Revision};
use crate::flockwave::transport::http::is_silence;
use crate::flockwave::transport::{MESSAGE_LIMIT, SOCKET_IO_PATH, socketio};
use crate::net::{Address, Connection};

/// The maximum time that sending may block.
const SEND_LIMIT: Duration = Duration::from_secs(30);

/// A stream with a read deadline, which applies even if single bytes keep arriving.
struct Limited {
    stream: TcpStream,
    until: Instant,
}

impl Read for Limited {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(left(self.until)?))?;
        self.stream.read(buffer)
    }
}

impl Write for Limited {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

pub(super) struct WebSocketClient {
    /// Dropping it closes the connection.
    _connection: Connection,
    socket: WebSocket<Limited>,
    heartbeat: Heartbeat,
    /// Packets that arrived during the handshake.
    early: VecDeque<Packet>,
}

impl WebSocketClient {
    pub(super) fn connect(address: &Address, revision: Revision, until: Instant) -> io::Result<Self> {
        let connection = Connection::open(address, until)?;
        let stream = connection.stream()?;
        stream.set_write_timeout(Some(SEND_LIMIT))?;
        let stream = Limited { stream, until };
        let number = revision.engine_io();
        let url = format!("ws://{address}{SOCKET_IO_PATH}?EIO={number}&transport=websocket");
        let request = url.into_client_request().map_err(to_io)?;
        let handshake = tungstenite::client::client_with_config(request, stream, Some(config()));
        let (socket, _) = handshake.map_err(|error| match error {
            HandshakeError::Failure(error) => to_io(error),
            HandshakeError::Interrupted(_) => timed_out("no WebSocket handshake"),
        })?;
        let heartbeat = Heartbeat::new(revision);
        let mut client = Self { _connection: connection, socket, heartbeat, early: VecDeque::new() };
        let mut opening = Opening::new(revision);
        while !opening.is_done() {
            left(until)?;
            let Some(packet) = client.packet(until)? else {
                return Err(invalid("the server closed the connection during the handshake"));
            };
            if let Some(answer) = opening.take(&packet, &mut client.heartbeat)? {
                client.send_packet(&answer)?;
            }
        }
        client.early = opening.early;
        Ok(client)
    }

    fn send_packet(&mut self, packet: &Packet) -> io::Result<()> {
        self.socket.send(Message::text(packet.to_text())).map_err(to_io)
    }

    /// The next packet. `None` at the end of the connection.
    fn packet(&mut self, until: Instant) -> io::Result<Option<Packet>> {
        if let Some(packet) = self.early.pop_front() {
            return Ok(Some(packet));
        }
        loop {
            left(until)?;
            self.socket.get_mut().until = until;
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let packet = Packet::parse(&text)
                        .ok_or_else(|| invalid("received a packet of an unknown kind"))?;
                    return Ok(Some(packet));
                }
                Ok(Message::Binary(_)) => return Err(invalid("received a binary packet")),
                Ok(Message::Close(_)) | Err(Error::ConnectionClosed | Error::AlreadyClosed) => {
                    return Ok(None);
                }
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
        self.send_packet(&Packet::new(Kind::Message, text_of(bytes)?))
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            if let Some(ping) = self.heartbeat.due() {
                self.send_packet(&ping)?;
            }
            let packet = match self.packet(self.heartbeat.next().min(until)) {
                Ok(Some(packet)) => packet,
                Ok(None) => return Ok(Received::End),
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                    if Instant::now() >= until {
                        return Ok(Received::Silence);
                    }
                    continue;
                }
                Err(error) => return Err(error),
            };
            match step(packet) {
                Step::Received(received) => return Ok(received),
                Step::Answer(answer) => self.send_packet(&answer)?,
                Step::Nothing => {}
            }
        }
    }
}

fn config() -> WebSocketConfig {
    // The packet adds only a few bytes to the message.
    let limit = MESSAGE_LIMIT + 1024;
    WebSocketConfig::default().max_message_size(Some(limit)).max_frame_size(Some(limit))
}

fn left(until: Instant) -> io::Result<Duration> {
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(timed_out("no packet")) } else { Ok(left) }
}

fn to_io(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => invalid(other.to_string()),
    }
}
