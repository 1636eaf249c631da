//! A TCP connection with a deadline, with or without TLS.

use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::time::Instant;

use super::timed::Timed;
use super::tls::{Trust, Wrapped, wrap};
use super::{Address, Connection};

/// A connection whose reads and writes end at a deadline.
pub struct Stream {
    inner: Inner,
    /// Dropping it closes the connection.
    connection: Connection,
}

enum Inner {
    Plain(Timed),
    Tls(Box<Wrapped>),
}

impl Stream {
    /// Connects, and completes the TLS handshake if there are certificates to trust.
    pub fn open(address: &Address, trust: Option<&Trust>, until: Instant) -> io::Result<Self> {
        let connection = Connection::open(address, until)?;
        let timed = Timed::new(connection.stream()?, until);
        let inner = match trust {
            None => Inner::Plain(timed),
            Some(trust) => Inner::Tls(Box::new(wrap(timed, &address.host, trust)?)),
        };
        Ok(Self { inner, connection })
    }

    /// Sets the deadline.
    pub fn set_deadline(&mut self, until: Instant) {
        match &mut self.inner {
            Inner::Plain(timed) => timed.set_deadline(until),
            Inner::Tls(wrapped) => wrapped.timed().set_deadline(until),
        }
    }

    /// True if the connection uses TLS.
    pub fn is_encrypted(&self) -> bool {
        matches!(self.inner, Inner::Tls(_))
    }

    /// Closes the sending direction.
    pub fn finish(&mut self) -> io::Result<()> {
        if let Inner::Tls(wrapped) = &mut self.inner {
            wrapped.finish()?;
        }
        self.connection.stream()?.shutdown(Shutdown::Write)
    }
}

impl Read for Stream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.inner {
            Inner::Plain(timed) => timed.read(buffer),
            Inner::Tls(wrapped) => wrapped.read(buffer),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.inner {
            Inner::Plain(timed) => timed.write(bytes),
            Inner::Tls(wrapped) => wrapped.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.inner {
            Inner::Plain(timed) => timed.flush(),
            Inner::Tls(wrapped) => wrapped.flush(),
        }
    }
}
