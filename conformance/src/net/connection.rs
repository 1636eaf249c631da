//! A connection to somebody who listens: a testee, or a live server. Nothing here waits longer than it is told to.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpStream, ToSocketAddrs as _};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::Address;

/// How often a testee is looked for that may be starting again.
const RETRY_INTERVAL: Duration = Duration::from_millis(50);

/// An open connection. Dropping it closes it.
pub(crate) struct Connection(TcpStream);

impl Connection {
    /// Connects to the first address of the host that takes connections.
    pub(crate) fn open(address: &Address, until: Instant) -> io::Result<Self> {
        let mut failure = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
        for found in resolve(address, until)? {
            let rest = until.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Err(too_late());
            }
            match TcpStream::connect_timeout(&found, rest) {
                Ok(stream) => {
                    // Without this a small question may wait for the answer to the one before.
                    stream.set_nodelay(true)?;
                    return Ok(Self(stream));
                }
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    /// Connects, trying again while the connection is refused: whoever watches over a testee that crashed takes a
    /// moment to start the next.
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

    /// One more handle of it: one is for reading, one for writing.
    pub(crate) fn stream(&self) -> io::Result<TcpStream> {
        self.0.try_clone()
    }

    /// Ends it, both ways.
    pub(crate) fn shut_down(&self) {
        // It may have ended by itself.
        let _ = self.0.shutdown(Shutdown::Both);
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.shut_down();
    }
}

/// The addresses of a host. The system's resolver knows no time limit, so a thread asks it, which nobody waits for.
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
    io::Error::new(io::ErrorKind::TimedOut, "no connection in time")
}
