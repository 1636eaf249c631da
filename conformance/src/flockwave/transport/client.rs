//! The client's end of a live connection.

mod http;
mod polling;
mod tcp;
mod udp;
mod websocket;

use std::io;
use std::time::Instant;

use super::endpoint::{Carrier, Endpoint};

/// What a client heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Received {
    /// A message, as it came.
    Message(Vec<u8>),
    /// A message over [`MESSAGE_LIMIT`](super::MESSAGE_LIMIT), of which nothing was kept.
    TooLong,
    /// Nothing, up to the given time.
    Silence,
    /// The server has closed the connection, or nothing of it is left: nothing more will come.
    End,
}

/// A connection to a server.
pub trait Client: Send {
    /// Sends a message: bytes that needn't be one, for those who try a server.
    fn send(&mut self, message: &[u8]) -> io::Result<()>;

    /// Waits for the next message.
    fn receive(&mut self, until: Instant) -> io::Result<Received>;

    /// Sends bytes as they are, with nothing that marks where a message ends: for messages in pieces, and several at
    /// once. Over Socket.IO they are a packet. Transports that have no such thing say so by an error.
    fn send_raw(&mut self, _bytes: &[u8]) -> io::Result<()> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "this transport can't send parts of a message"))
    }

    /// Says that nothing more will be sent, where the transport can say so without ending the connection.
    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Connects to a server, up to where messages can be sent. HTTP has no connection: each message may take as long.
pub fn connect(endpoint: &Endpoint, until: Instant) -> io::Result<Box<dyn Client>> {
    Ok(match endpoint {
        Endpoint::Tcp(address) => Box::new(tcp::Tcp::connect(address, until)?),
        Endpoint::Udp(address) => Box::new(udp::Udp::connect(address, until)?),
        Endpoint::Http { address, path } => {
            let limit = until.saturating_duration_since(Instant::now());
            Box::new(http::OneShot::new(address, path, limit))
        }
        Endpoint::SocketIo { address, revision, carrier: Carrier::WebSocket } => {
            Box::new(websocket::WebSocketClient::connect(address, *revision, until)?)
        }
        Endpoint::SocketIo { address, revision, carrier: Carrier::Polling } => {
            Box::new(polling::Polling::connect(address, *revision, until)?)
        }
    })
}

/// What is to be sent over Socket.IO.
fn text_of(bytes: &[u8]) -> io::Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| odd("Socket.IO carries text only"))
}

/// An error about what a server did.
fn odd(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message.into())
}

/// The error where the time is over.
fn late(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::TimedOut, format!("{what} in time"))
}
