//! The client side of live connections.

mod http;
mod polling;
mod status;
mod target;
mod tcp;
mod udp;
mod websocket;

use std::io;
use std::time::Instant;

pub use self::status::http_status;
use self::target::Target;
use super::access::Access;
use super::endpoint::{Carrier, Endpoint};

/// The result of waiting for a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Received {
    /// A message, unchanged.
    Message(Vec<u8>),
    /// The argument of a Socket.IO event with a name other than `fw`.
    OtherEvent(Vec<u8>),
    /// A message longer than [`MESSAGE_LIMIT`](super::MESSAGE_LIMIT), which was dropped.
    TooLong,
    /// No message arrived within the given time.
    Silence,
    /// The connection is closed, so nothing more will arrive.
    End,
}

/// A connection to a server.
pub trait Client {
    /// Sends a message. To test servers, callers may pass bytes that aren't a valid message.
    fn send(&mut self, message: &[u8]) -> io::Result<()>;

    /// Waits for the next message.
    fn receive(&mut self, until: Instant) -> io::Result<Received>;

    /// Sends bytes without framing, e.g. parts of a message or several messages. With Socket.IO, the bytes form a
    /// packet. Fails if the transport doesn't support this.
    fn send_raw(&mut self, _bytes: &[u8]) -> io::Result<()> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "this transport can't send a message in parts"))
    }

    /// Closes the sending direction, if the transport supports that.
    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A network in memory. Neither connecting nor sending blocks.
pub trait Network {
    /// Connects to a server.
    ///
    /// # Errors
    /// Fails if there is no such server, or if it refuses the connection.
    fn connect(&self, endpoint: &Endpoint) -> io::Result<Box<dyn Client>>;
}

/// Connects to a server and completes the handshake, without credentials. HTTP has no lasting connection, so the time
/// limit also applies to each message.
pub fn connect(endpoint: &Endpoint, until: Instant) -> io::Result<Box<dyn Client + Send>> {
    connect_with(endpoint, &Access::default(), until)
}

/// Like [`connect`], with credentials and trusted certificates.
pub fn connect_with(
    endpoint: &Endpoint,
    access: &Access,
    until: Instant,
) -> io::Result<Box<dyn Client + Send>> {
    Ok(match endpoint {
        Endpoint::Tcp(address) => Box::new(tcp::Tcp::connect(address, access, until)?),
        Endpoint::Udp(address) => Box::new(udp::Udp::connect(address, until)?),
        Endpoint::Http { address, path } => {
            Box::new(http::OneShot::connect(Target::new(address, path), access, until)?)
        }
        Endpoint::SocketIo { address, revision, carrier: Carrier::WebSocket } => {
            Box::new(websocket::WebSocketClient::connect(address, *revision, access, until)?)
        }
        Endpoint::SocketIo { address, revision, carrier: Carrier::Polling } => {
            Box::new(polling::Polling::connect(address, *revision, access, until)?)
        }
    })
}

/// True if a connection that failed with this error may succeed later, e.g. because the server is starting. False for
/// an unknown host, a refused login, an invalid certificate, or a server of another kind.
pub fn is_temporary(error: &io::Error) -> bool {
    use io::ErrorKind::{
        BrokenPipe, ConnectionAborted, ConnectionRefused, ConnectionReset, HostUnreachable,
        NetworkUnreachable, TimedOut, UnexpectedEof,
    };
    let is_down = matches!(
        error.kind(),
        BrokenPipe
            | ConnectionAborted
            | ConnectionRefused
            | ConnectionReset
            | HostUnreachable
            | NetworkUnreachable
            | TimedOut
            | UnexpectedEof
    );
    is_down || matches!(http_status(error), Some(502..=504))
}

/// The text to send over Socket.IO.
fn text_of(bytes: &[u8]) -> io::Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| invalid("Socket.IO carries text only"))
}

/// An error for unexpected server behaviour.
fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

/// The error for an exceeded time limit.
fn timed_out(event: &str) -> io::Error {
    io::Error::new(io::ErrorKind::TimedOut, format!("{event} in time"))
}
