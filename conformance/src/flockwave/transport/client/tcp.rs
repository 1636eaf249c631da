//! TCP: one message on each line.

use std::io::{self, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use super::{Client, Received};
use crate::flockwave::transport::http::is_silence;
use crate::flockwave::transport::lines::{Line, Lines};
use crate::net::{Address, Connection};

/// The maximum time that sending may block.
const SEND_LIMIT: Duration = Duration::from_secs(30);

pub(super) struct Tcp {
    /// Dropping it closes the connection.
    _connection: Connection,
    stream: TcpStream,
    lines: Lines,
}

impl Tcp {
    pub(super) fn connect(address: &Address, until: Instant) -> io::Result<Self> {
        let connection = Connection::open(address, until)?;
        let stream = connection.stream()?;
        stream.set_write_timeout(Some(SEND_LIMIT))?;
        Ok(Self { _connection: connection, stream, lines: Lines::default() })
    }
}

impl Client for Tcp {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        let mut line = Vec::with_capacity(message.len() + 1);
        line.extend_from_slice(message);
        line.push(b'\n');
        self.send_raw(&line)
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.stream.shutdown(Shutdown::Write)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        let mut piece = [0; 16 << 10];
        loop {
            match self.lines.take() {
                Some(Line::Whole(line)) => return Ok(Received::Message(line)),
                Some(Line::TooLong) => return Ok(Received::TooLong),
                None => {}
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(Received::Silence);
            }
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(&mut piece) {
                Ok(0) => return Ok(Received::End),
                Ok(length) => self.lines.feed(&piece[..length]),
                Err(error) if is_silence(&error) => {}
                Err(error) => return Err(error),
            }
        }
    }
}
