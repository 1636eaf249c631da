//! A connection: reads and writes a stream, and passes the bytes to the protocol of the transport.

use std::io::{ErrorKind, Read as _};
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::TcpStream;

use super::limits::{
    DISCONNECTED, MESSAGE_TIME, PAUSE_LIMIT, Reason, SEND_LIMIT, STEPS_AT_ONCE, Share, TOO_MUCH, TOO_SLOW,
    UNFINISHED,
};
use super::outbox::{Outbox, State};
use super::seats::Seat;
use super::tcp::LineClient;
use super::web::WebClient;
use super::{Shared, Transport};
use crate::hub::Sink as _;

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

    /// The memory of received bytes that have not been processed yet.
    fn unfinished(&self) -> usize;

    /// Tells the client the reason, if the protocol permits it, and releases everything that belongs to the connection.
    fn end(&mut self, shared: &mut Shared, reason: Reason);
}

/// A connection.
pub(super) struct Connection {
    stream: Rc<TcpStream>,
    outbox: Rc<Outbox>,
    protocol: Box<dyn Protocol>,
    /// The memory of received bytes.
    received: Share,
    pub(super) seat: Seat,
    /// The time at which the first bytes of an incomplete message arrived.
    incomplete_since: Option<Instant>,
    /// The time at which the server closed its side.
    closed_at: Option<Instant>,
    /// True if the client closed its side.
    has_ended: bool,
}

impl Connection {
    /// Serves a stream.
    pub(super) fn new(shared: &mut Shared, stream: TcpStream, transport: Transport) -> Self {
        let stream = Rc::new(stream);
        let outbox = Rc::new(shared.outbox(Some(Rc::clone(&stream))));
        let protocol: Box<dyn Protocol> = match transport {
            Transport::Tcp => Box::new(LineClient::new(shared, &outbox)),
            _ => Box::new(WebClient::new()),
        };
        Self {
            stream,
            outbox,
            protocol,
            received: Share::new(&shared.received),
            seat: Seat::new(shared.now()),
            incomplete_since: None,
            closed_at: None,
            has_ended: false,
        }
    }

    /// Sends waiting bytes, and processes some messages. Returns true if anything happened, so there may be more to do.
    pub(super) fn visit(&mut self, shared: &mut Shared) -> Result<bool, Reason> {
        let mut steps = 0;
        while steps < STEPS_AT_ONCE && self.advance(shared)? {
            steps += 1;
        }
        self.received.set(self.protocol.unfinished());
        if self.received.is_exceeded() {
            return Err(TOO_MUCH);
        }
        let now = shared.now();
        for (since, limit, reason) in [
            (self.outbox.waiting_since(), SEND_LIMIT, TOO_SLOW),
            (self.closed_at, LINGER_TIME, DISCONNECTED),
            (self.incomplete_since, MESSAGE_TIME, UNFINISHED),
        ] {
            if since.is_some_and(|since| now.saturating_duration_since(since) >= limit) {
                return Err(reason);
            }
        }
        Ok(steps > 0)
    }

    /// Processes a message, or reads bytes. Returns false if neither is possible at the moment.
    fn advance(&mut self, shared: &mut Shared) -> Result<bool, Reason> {
        match self.outbox.flush() {
            State::Failed(reason) => return Err(reason),
            State::Closing => return Ok(false),
            State::Sent if self.has_ended => return Err(DISCONNECTED),
            State::Sent => {
                self.closed_at.get_or_insert(shared.now());
                return self.read(shared);
            }
            State::Open if self.outbox.waiting() > PAUSE_LIMIT => return Ok(false),
            State::Open => {}
        }
        match self.protocol.step(shared, &self.outbox) {
            Step::Handled { is_request } => {
                self.incomplete_since = None;
                if is_request {
                    self.seat = Seat::of_active(shared.now());
                }
            }
            Step::Upgrade(protocol) => {
                self.protocol = protocol;
                self.seat = Seat::of_active(shared.now());
            }
            Step::Waiting => {
                self.incomplete_since = None;
                // A client that has disconnected gets no response.
                return if matches!(self.stream.take_error(), Ok(None)) {
                    Ok(false)
                } else {
                    Err(DISCONNECTED)
                };
            }
            Step::Starved if !self.has_ended => {
                let has_read = self.read(shared)?;
                if !has_read {
                    let since = self.incomplete_since.unwrap_or_else(|| shared.now());
                    self.incomplete_since = (self.protocol.unfinished() > 0).then_some(since);
                }
                return Ok(has_read);
            }
            Step::Starved | Step::End => self.outbox.close(),
        }
        Ok(true)
    }

    /// Reads bytes. If the server has closed its side, they are dropped. Returns false if none have arrived.
    fn read(&mut self, shared: &mut Shared) -> Result<bool, Reason> {
        let piece = &mut shared.piece;
        match (&*self.stream).read(piece) {
            Ok(0) => self.has_ended = true,
            Ok(_) if self.outbox.is_closed() => {}
            Ok(length) => self.protocol.feed(&piece[..length]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(false),
            Err(_) => return Err(DISCONNECTED),
        }
        Ok(true)
    }

    /// True if bytes wait to be sent.
    pub(super) fn is_sending(&self) -> bool {
        self.outbox.waiting() > 0
    }

    /// Ends the connection. If the client can still receive messages, it receives the reason.
    pub(super) fn end(&mut self, shared: &mut Shared, reason: Reason) {
        shared.count(reason);
        self.protocol.end(shared, reason.filter(|_| !self.outbox.is_closed()));
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

    /// The number of visits that a text from a client causes.
    fn visits(text: &str) -> usize {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let mut client = net::TcpStream::connect(listener.local_addr().expect("a port")).expect("a client");
        let (stream, _) = listener.accept().expect("a client");
        client.write_all(text.as_bytes()).expect("sent");
        // The text has arrived when it can be read.
        stream.peek(&mut [0]).expect("a byte");
        stream.set_nonblocking(true).expect("a setting");
        let mut shared = Shared::new(Hub::new(Options::default(), answer));
        let mut connection = Connection::new(&mut shared, TcpStream::from_std(stream), Transport::Tcp);
        let mut visits = 0;
        while connection.visit(&mut shared).expect("an open connection") {
            visits += 1;
        }
        visits
    }

    #[test]
    fn a_client_that_sent_many_messages_lets_others_have_their_turn() {
        let long = format!(
            "{{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{{\"type\":\"UAV-INF\",\"ids\":[\"{}\"]}}}}\n",
            "x".repeat(5000)
        );
        assert_eq!([visits(&long), visits(&long[..100])], [1, 1]);
        let short = "{\"$fw.version\":\"1.0\",\"id\":\"a\",\"body\":{\"type\":\"SYS-PING\"}}\n";
        assert!(visits(&short.repeat(200)) > 10);
    }
}
