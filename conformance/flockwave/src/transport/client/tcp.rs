//! TCP: one message on each line.

use std::io::{self, Read as _, Write as _};
use std::time::{Duration, Instant};

use serde::de::IgnoredAny;
use uavspec_model::clock::Clock;
use uavspec_model::net::{Stream, is_silence};

use super::{Client, Received, invalid};
use crate::transport::MESSAGE_LIMIT;
use crate::transport::access::Access;
use crate::transport::endpoint::ServerAddress;
use crate::transport::lines::{Line, Lines};

/// The maximum time that sending may block.
const SEND_LIMIT: Duration = Duration::from_secs(30);

pub(super) struct Tcp {
    stream: Stream,
    lines: Lines,
    has_received: bool,
}

impl Tcp {
    pub(super) fn connect(address: &ServerAddress, access: &Access, until: Instant) -> io::Result<Self> {
        let stream = Stream::open(&address.address(), access.trust(address.is_encrypted), until)?;
        Ok(Self { stream, lines: Lines::new(MESSAGE_LIMIT), has_received: false })
    }

    /// Stores received bytes. Fails if they are a TLS message: TLS servers send one to refuse clients without TLS.
    fn take(&mut self, bytes: &[u8]) -> io::Result<()> {
        let is_first = !std::mem::replace(&mut self.has_received, true);
        if is_first && !self.stream.is_encrypted() && matches!(bytes, [0x15 | 0x16, 3, ..]) {
            return Err(invalid("the server uses TLS on this port: use a tcps:// URL"));
        }
        self.lines.feed(bytes);
        Ok(())
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
        self.stream.set_deadline(Clock::real().now() + SEND_LIMIT);
        self.stream.write_all(bytes)?;
        self.stream.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.stream.set_deadline(Clock::real().now() + SEND_LIMIT);
        self.stream.finish()
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        let mut piece = [0; 16 << 10];
        loop {
            match self.lines.take() {
                Some(Line::Whole(line)) => return Ok(Received::Message(line)),
                Some(Line::TooLong) => return Ok(Received::TooLong),
                None => {}
            }
            if Clock::real().now() >= until {
                return Ok(Received::Silence);
            }
            self.stream.set_deadline(until);
            match self.stream.read(&mut piece) {
                // Line breaks separate messages, so the last message needs none.
                Ok(0) => {
                    let rest = self.lines.take_rest();
                    let is_message = serde_json::from_slice::<IgnoredAny>(&rest).is_ok();
                    return Ok(if is_message { Received::Message(rest) } else { Received::End });
                }
                Ok(length) => self.take(&piece[..length])?,
                Err(error) if is_silence(&error) => {}
                Err(error) => return Err(error),
            }
        }
    }
}
