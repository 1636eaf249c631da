//! A connection to a testee or a live server. All waits have a time limit.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpStream, ToSocketAddrs as _};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::Address;

/// The interval between attempts to connect to a testee that may be restarting.
const RETRY_INTERVAL: Duration = Duration::from_millis(50);

/// An open connection, which is closed when dropped.
pub(crate) struct Connection(TcpStream);

impl Connection {
    /// Connects to the first of the host's addresses that accepts the connection.
    pub(crate) fn open(address: &Address, until: Instant) -> io::Result<Self> {
        let mut failure = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
        for found in resolve(address, until)? {
            let rest = until.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Err(too_late());
            }
            match TcpStream::connect_timeout(&found, rest) {
                Ok(stream) => {
                    // Otherwise, a small message may wait for the answer to the previous message.
                    stream.set_nodelay(true)?;
                    return Ok(Self(stream));
                }
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    /// Connects, and retries while the connection is refused. A supervisor may need a moment to restart a testee that
    /// crashed.
    pub(crate) fn open_again(address: &Address, until: Instant) -> io::Result<Self> {
        loop {
            match Self::open(address, until) {
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused && Instant::now() < until => {
                    thread::sleep(RETRY_INTERVAL);
                }
                other => return other,
            }
        }
    }

    /// Another handle to the connection. One handle can then read while the other writes.
    pub(crate) fn stream(&self) -> io::Result<TcpStream> {
        self.0.try_clone()
    }

    /// Closes both directions of the connection.
    pub(crate) fn shut_down(&self) {
        // The peer may already have closed the connection.
        let _ = self.0.shutdown(Shutdown::Both);
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.shut_down();
    }
}

/// Resolves the addresses of a host. The system's resolver has no time limit, so a separate thread calls it.
pub(crate) fn resolve(address: &Address, until: Instant) -> io::Result<Vec<SocketAddr>> {
    let (sender, found) = channel();
    let (host, port) = (address.host.clone(), address.port);
    thread::spawn(move || {
        let addresses = (host.as_str(), port).to_socket_addrs();
        let _ = sender.send(addresses.map(Iterator::collect));
    });
    match found.recv_timeout(until.saturating_duration_since(Instant::now())) {
        Ok(addresses) => addresses,
        Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(too_late()),
    }
}

fn too_late() -> io::Error {
    io::Error::new(io::ErrorKind::TimedOut, "couldn't connect within the time limit")
}
