//! A connection: reads and writes a stream, and passes the bytes to the protocol of the transport.

use std::io::{ErrorKind, Read as _};
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::TcpStream;

use super::Shared;
use super::limits::{MESSAGE_TIME, PAUSE_LIMIT, SEND_LIMIT, Share};
use super::outbox::Outbox;
use super::statistics::Reason;

/// The number of bytes to read in one step.
const PIECE: usize = 16 << 10;

/// The maximum number of messages and reads in a visit. Then other connections have their turn.
const STEPS_AT_ONCE: usize = 16;

/// The time during which a closed connection waits until the client closes it as well. Otherwise, the client could lose
/// the last messages.
const LINGER_TIME: Duration = Duration::from_millis(500);

/// The result of [`Protocol::step`].
pub(super) enum Step {
    /// A message was processed.
    Handled {
        /// True if the message was a valid request.
        is_request: bool,
    },
    /// The next message is incomplete.
    Starved,
    /// The next message is processed after a response to the previous one.
    Waiting,
    /// The connection ends after the waiting bytes have been sent.
    End,
    /// Another protocol continues.
    Upgrade(Box<dyn Protocol>),
}

/// The protocol of a transport.
pub(super) trait Protocol {
    /// Adds received bytes.
    fn feed(&mut self, bytes: &[u8]);

    /// Processes the next message.
    fn step(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>) -> Step;

    /// True if the response for which the protocol waits may be available.
    fn is_due(&self) -> bool {
        true
    }

    /// True if there is an incomplete message.
    fn has_rest(&self) -> bool;

    /// The memory of received bytes.
    fn capacity(&self) -> usize;

    /// The maximum time without messages.
    fn idle_limit(&self) -> Option<Duration> {
        None
    }

    /// Tells the client why the server closes the connection, if the protocol permits it.
    fn dismiss(&mut self, _shared: &mut Shared, _reason: Reason) {}

    /// Releases everything that belongs to the connection.
    fn end(&mut self, shared: &mut Shared);
}

/// The state of a connection after [`Connection::visit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Visit {
    /// There may be more to do.
    Again,
    /// The connection waits for an event of its stream.
    Rest,
    /// The connection waits for a response.
    Waiting,
    /// The connection has ended.
    End(Reason),
}

/// A connection.
pub(super) struct Connection {
    stream: Rc<TcpStream>,
    outbox: Rc<Outbox>,
    protocol: Box<dyn Protocol>,
    /// The memory of received bytes.
    received: Share,
    last_active: Instant,
    /// True if a valid request arrived since the last call of [`Self::has_requested`].
    has_requested: bool,
    /// The time at which the first bytes of an incomplete message arrived.
    incomplete_since: Option<Instant>,
    /// The time at which the server closed its side.
    closed_at: Option<Instant>,
    /// True if the client closed its side.
    has_ended: bool,
}

impl Connection {
    /// Serves a stream with a protocol.
    pub(super) fn new(
        shared: &mut Shared,
        stream: TcpStream,
        protocol: impl FnOnce(&mut Shared, &Rc<Outbox>) -> Box<dyn Protocol>,
    ) -> Self {
        let stream = Rc::new(stream);
        let outbox = Rc::new(Outbox::new(Rc::clone(&stream), &shared.queued, shared.clock.clone()));
        let protocol = protocol(shared, &outbox);
        Self {
            stream,
            outbox,
            protocol,
            received: Share::new(&shared.received),
            last_active: shared.now(),
            has_requested: false,
            incomplete_since: None,
            closed_at: None,
            has_ended: false,
        }
    }

    /// True if the response for which the connection waits may be available.
    pub(super) fn is_due(&self) -> bool {
        self.protocol.is_due()
    }

    /// True if a valid request arrived since the last call.
    pub(super) fn has_requested(&mut self) -> bool {
        std::mem::take(&mut self.has_requested)
    }

    /// True if the server has closed its side.
    pub(super) fn is_closed(&self) -> bool {
        self.outbox.is_closed()
    }

    /// Sends waiting bytes, and processes some messages.
    pub(super) fn visit(&mut self, shared: &mut Shared) -> Visit {
        for _ in 0..STEPS_AT_ONCE {
            self.outbox.flush();
            if let Some(reason) = self.outbox.failure() {
                return Visit::End(reason);
            }
            let visit = if self.is_closed() { self.linger(shared.now()) } else { self.advance(shared) };
            if let Some(visit) = visit {
                return visit;
            }
        }
        Visit::Again
    }

    /// Processes a message or reads bytes. Returns `None` if the connection can continue.
    fn advance(&mut self, shared: &mut Shared) -> Option<Visit> {
        if self.outbox.waiting() > PAUSE_LIMIT {
            return Some(Visit::Rest);
        }
        match self.protocol.step(shared, &self.outbox) {
            Step::Handled { is_request } => {
                self.last_active = shared.now();
                self.incomplete_since = None;
                self.has_requested |= is_request;
                None
            }
            Step::Upgrade(protocol) => {
                self.protocol = protocol;
                self.has_requested = true;
                None
            }
            Step::Waiting => Some(Visit::Waiting),
            Step::End => {
                self.outbox.close();
                None
            }
            Step::Starved if self.has_ended => {
                self.outbox.close();
                None
            }
            Step::Starved => self.read(shared.now()),
        }
    }

    /// Reads bytes. Returns `None` if the connection can continue.
    fn read(&mut self, now: Instant) -> Option<Visit> {
        let mut piece = [0; PIECE];
        match (&*self.stream).read(&mut piece) {
            Ok(0) => self.has_ended = true,
            Ok(length) => self.protocol.feed(&piece[..length]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let since = self.incomplete_since.unwrap_or(now);
                self.incomplete_since = self.protocol.has_rest().then_some(since);
                return Some(Visit::Rest);
            }
            Err(_) => return Some(Visit::End(Reason::Disconnected)),
        }
        let is_exceeded = self.received.set(self.protocol.capacity()).is_err();
        is_exceeded.then_some(Visit::End(Reason::TooMuch))
    }

    /// Drops received bytes until the client closes the connection.
    fn linger(&mut self, now: Instant) -> Option<Visit> {
        if !self.outbox.is_sent() {
            return Some(Visit::Rest);
        }
        self.closed_at.get_or_insert(now);
        if self.has_ended {
            return Some(Visit::End(Reason::Disconnected));
        }
        match (&*self.stream).read(&mut [0; PIECE]) {
            Ok(0) => self.has_ended = true,
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Some(Visit::Rest),
            Err(_) => self.has_ended = true,
        }
        None
    }

    /// The reason to end the connection, if a time limit is exceeded.
    pub(super) fn overdue(&self, now: Instant) -> Option<Reason> {
        let has_passed = |since: Option<Instant>, limit| {
            since.is_some_and(|since| now.saturating_duration_since(since) >= limit)
        };
        let idle_limit = self.protocol.idle_limit().filter(|_| !self.is_closed());
        if self.outbox.waiting_time(now) >= SEND_LIMIT {
            Some(Reason::TooSlow)
        } else if has_passed(self.closed_at, LINGER_TIME) {
            Some(Reason::Disconnected)
        } else if has_passed(self.incomplete_since, MESSAGE_TIME) {
            Some(Reason::Unfinished)
        } else if idle_limit.is_some_and(|limit| has_passed(Some(self.last_active), limit)) {
            Some(Reason::Idle)
        } else {
            None
        }
    }

    /// Ends the connection. If the client can still receive messages, it receives the reason.
    pub(super) fn end(mut self, shared: &mut Shared, reason: Reason) {
        if reason != Reason::Disconnected && !self.is_closed() {
            self.protocol.dismiss(shared, reason);
        }
        self.protocol.end(shared);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::net::{self, TcpListener};

    use super::*;
    use crate::Options;
    use crate::family::answer;
    use crate::hub::Hub;
    use crate::listen::tcp::LineClient;

    /// Visits a connection once, after its client has sent this text.
    fn visit(text: &str) -> Visit {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let mut client = net::TcpStream::connect(listener.local_addr().expect("a port")).expect("a client");
        let (stream, _) = listener.accept().expect("a client");
        client.write_all(text.as_bytes()).expect("sent");
        // The text has arrived when it can be read.
        stream.peek(&mut [0]).expect("a byte");
        stream.set_nonblocking(true).expect("a setting");
        let mut shared = Shared::new(Hub::new(Options::default(), answer));
        let stream = TcpStream::from_std(stream);
        let mut connection =
            Connection::new(&mut shared, stream, |shared, outbox| Box::new(LineClient::new(shared, outbox)));
        connection.visit(&mut shared)
    }

    #[test]
    fn a_client_that_sent_many_messages_lets_others_have_their_turn() {
        let long = format!(
            "{{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{{\"type\":\"UAV-INF\",\"ids\":[\"{}\"]}}}}\n",
            "x".repeat(5000)
        );
        assert_eq!(visit(&long), Visit::Rest);
        assert_eq!(visit(&long[..100]), Visit::Rest);
        let short = "{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{\"type\":\"SYS-PING\"}}\n";
        assert_eq!(visit(&short.repeat(200)), Visit::Again);
    }
}
