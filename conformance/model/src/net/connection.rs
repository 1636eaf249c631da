//! A connection to a testee or a live server. All waits have a time limit.

use std::net::{Shutdown, SocketAddr, TcpStream, ToSocketAddrs as _};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use std::{fmt, io, thread};

use super::Address;
use crate::clock::Clock;

/// The interval between attempts to connect to a testee that may be restarting.
const RETRY_INTERVAL: Duration = Duration::from_millis(50);

/// An open connection, which is closed when dropped.
pub struct Connection(TcpStream);

impl Connection {
    /// Connects to the first of the host's addresses that accepts the connection.
    pub(crate) fn open(address: &Address, until: Instant) -> io::Result<Self> {
        let mut failure = None;
        let found = resolve(address, until)?;
        for (at, candidate) in found.iter().enumerate() {
            // An address that doesn't respond must leave time for the next one.
            let remaining = u32::try_from(found.len() - at).unwrap_or(u32::MAX);
            let rest = Clock::real().left(until) / remaining;
            if rest.is_zero() {
                return Err(too_late(address));
            }
            match TcpStream::connect_timeout(candidate, rest) {
                Ok(stream) => {
                    // Otherwise, a small message may wait for the answer to the previous message.
                    stream.set_nodelay(true)?;
                    return Ok(Self(stream));
                }
                Err(error) => failure = Some(error),
            }
        }
        Err(failure
            .map_or_else(|| not_found(&address.host, "it has no address"), |error| explain(address, error)))
    }

    /// Connects within a time limit. Retries for a further period while the connection is refused: a supervisor may
    /// need a moment to restart a testee that crashed.
    pub fn open_again(
        address: &Address,
        (limit, retrying): (Duration, Duration),
        clock: &Clock,
    ) -> io::Result<Self> {
        let until = clock.now() + retrying;
        loop {
            match Self::open(address, Clock::real().now() + limit) {
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused && clock.now() < until => {
                    clock.sleep(RETRY_INTERVAL);
                }
                other => return other,
            }
        }
    }

    /// Creates another handle to the connection, so that one handle can read while the other writes.
    pub fn stream(&self) -> io::Result<TcpStream> {
        self.0.try_clone()
    }

    /// Closes both directions of the connection.
    pub fn shut_down(&self) {
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
pub fn resolve(address: &Address, until: Instant) -> io::Result<Vec<SocketAddr>> {
    let (sender, found) = channel();
    let (host, port) = (address.host.clone(), address.port);
    thread::spawn(move || {
        let addresses = (host.as_str(), port).to_socket_addrs();
        let _ = sender.send(addresses.map(Iterator::collect));
    });
    match Clock::real().receive(&found, until) {
        Ok(addresses) => addresses.map_err(|error| not_found(&address.host, error)),
        Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => Err(too_late(address)),
    }
}

/// Names the cause of an error while connecting to an address.
pub fn explain(address: &Address, error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => {
            io::Error::new(error.kind(), format!("connection refused: no server listens on {address}"))
        }
        io::ErrorKind::TimedOut => too_late(address),
        io::ErrorKind::HostUnreachable | io::ErrorKind::NetworkUnreachable => {
            io::Error::new(error.kind(), format!("{address} is unreachable: {error}"))
        }
        _ => error,
    }
}

fn not_found(host: &str, why: impl fmt::Display) -> io::Error {
    io::Error::new(io::ErrorKind::NotFound, format!("host not found: {host}: {why}"))
}

fn too_late(address: &Address) -> io::Error {
    io::Error::new(
        io::ErrorKind::TimedOut,
        format!("timed out: couldn't connect to {address} within the time limit"),
    )
}
