//! A TCP stream with a deadline.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use crate::clock::Clock;

/// True if an error only means that nothing arrived in time.
pub fn is_silence(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}

/// A stream with a deadline, which applies even if single bytes keep arriving.
pub(super) struct Timed {
    stream: TcpStream,
    until: Instant,
}

impl Timed {
    pub(super) fn new(stream: TcpStream, until: Instant) -> Self {
        Self { stream, until }
    }

    pub(super) fn set_deadline(&mut self, until: Instant) {
        self.until = until;
    }
}

impl Read for Timed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = Clock::real().left(self.until);
        if left.is_zero() {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "timed out: nothing received in time"));
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(buffer)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let timed_out =
            || io::Error::new(io::ErrorKind::TimedOut, "timed out: the server doesn't read the sent data");
        let left = Clock::real().left(self.until);
        if left.is_zero() {
            return Err(timed_out());
        }
        self.stream.set_write_timeout(Some(left))?;
        self.stream.write(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => timed_out(),
            _ => error,
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}
