//! A server in memory that clients call directly, and that gets its time from a [`Clock`]. With a simulated clock, a
//! session takes no real time, and the same requests always lead to the same messages.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::rc::Rc;
use std::time::{Duration, Instant};

use uavspec_flockwave::transport::client::{Client, Network, Received};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_flockwave::transport::lines::{Line, Lines};
use uavspec_model::clock::Clock;

use super::hub::{ConnectionKind, Hub, SessionId, Sink};
use super::listen::{REQUEST_LIMIT, TICK};
use super::{Options, family};

/// The time that a message takes from the client to the server.
const DELAY: Duration = Duration::from_millis(1);

/// The port that the server reports.
const PORT: u16 = 5001;

/// A server that clients call directly, as if over TCP or UDP at port 5001. Clones share the server.
#[derive(Clone)]
pub struct InMemory(Rc<RefCell<State>>);

struct State {
    hub: Hub,
    clock: Clock,
    start: Instant,
    /// The time until which the server has advanced, since its start.
    advanced: Duration,
}

impl State {
    /// Advances the server to the current time. Returns the time since its start.
    fn advance(&mut self) -> Duration {
        let elapsed = self.clock.now().saturating_duration_since(self.start);
        while self.advanced + TICK <= elapsed {
            self.advanced += TICK;
            self.hub.advance(self.advanced);
        }
        elapsed
    }

    /// The time at which the server advances next.
    fn next(&self) -> Instant {
        self.start + self.advanced + TICK
    }
}

impl InMemory {
    /// Starts a server whose time is initially the current time of `clock`.
    pub fn new(options: Options, clock: &Clock) -> Self {
        let start = u64::try_from(clock.since_1970().as_millis()).unwrap_or_default();
        let mut hub = Hub::new(Options { start, ..options }, family::answer);
        hub.ports = [("tcp", PORT), ("udp", PORT)].into();
        let (clock, start) = (clock.clone(), clock.now());
        Self(Rc::new(RefCell::new(State { hub, clock, start, advanced: Duration::ZERO })))
    }

    /// Connects to the server.
    fn open(&self, kind: ConnectionKind) -> MemoryClient {
        let queue = Rc::new(Queue::default());
        let mut state = self.0.borrow_mut();
        state.advance();
        let session = state.hub.open(kind, Rc::<Queue>::clone(&queue));
        drop(state);
        let is_stream = kind == ConnectionKind::Persistent;
        MemoryClient { server: self.clone(), session, queue, lines: Lines::new(REQUEST_LIMIT), is_stream }
    }
}

impl Network for InMemory {
    fn connect(&self, endpoint: &Endpoint) -> io::Result<Box<dyn Client>> {
        let kind = match endpoint {
            Endpoint::Tcp(_) => ConnectionKind::Persistent,
            Endpoint::Udp(_) => ConnectionKind::Datagrams,
            _ => {
                return Err(io::Error::new(
                    ErrorKind::Unsupported,
                    "the server in memory has no such transport",
                ));
            }
        };
        Ok(Box::new(self.open(kind)))
    }
}

/// Messages from the server that the client hasn't received yet.
#[derive(Default)]
pub(super) struct Queue {
    pub(super) texts: RefCell<VecDeque<String>>,
    is_closed: Cell<bool>,
}

impl Sink for Queue {
    fn send(&self, text: &str) {
        if !self.is_closed.get() {
            self.texts.borrow_mut().push_back(text.to_owned());
        }
    }

    fn close(&self) {
        self.is_closed.set(true);
    }
}

/// A client of the server.
struct MemoryClient {
    server: InMemory,
    session: SessionId,
    queue: Rc<Queue>,
    lines: Lines,
    /// True if requests are lines. False if they are datagrams.
    is_stream: bool,
}

impl MemoryClient {
    /// Passes a message to the server after the delay.
    fn deliver(&self, message: &[u8]) {
        let mut state = self.server.0.borrow_mut();
        state.clock.sleep(DELAY);
        let elapsed = state.advance();
        state.hub.receive(self.session, message, elapsed);
    }

    fn deliver_lines(&mut self, bytes: &[u8]) {
        self.lines.feed(bytes);
        while let Some(line) = self.lines.take() {
            if let Line::Whole(line) = line {
                self.deliver(&line);
            }
        }
    }
}

impl Client for MemoryClient {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        if self.is_stream {
            return self.send_raw(&[message, b"\n"].concat());
        }
        self.deliver(message);
        Ok(())
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.queue.is_closed.get() {
            return Err(ErrorKind::BrokenPipe.into());
        }
        self.deliver_lines(bytes);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            let mut state = self.server.0.borrow_mut();
            state.advance();
            if let Some(text) = self.queue.texts.borrow_mut().pop_front() {
                return Ok(Received::Message(text.into_bytes()));
            }
            if self.queue.is_closed.get() {
                return Ok(Received::End);
            }
            if state.clock.now() >= until {
                return Ok(Received::Silence);
            }
            let next = state.next().min(until);
            state.clock.sleep_until(next);
        }
    }
}

impl Drop for MemoryClient {
    fn drop(&mut self) {
        self.server.0.borrow_mut().hub.close(self.session);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts that a client receives within a time.
    fn received(client: &mut dyn Client, until: Instant) -> Vec<String> {
        let mut texts = Vec::new();
        while let Ok(Received::Message(bytes)) = client.receive(until) {
            texts.push(String::from_utf8(bytes).expect("UTF-8"));
        }
        texts
    }

    #[test]
    fn clients_and_server_share_their_time() {
        let session = || {
            let clock = Clock::simulated();
            let server = InMemory::new(Options::default(), &clock);
            let mut client = server.connect(&"tcp://memory:1".parse().expect("a URL")).expect("a client");
            let request = br#"{"$fw.version":"1.0","id":"now","body":{"type":"SYS-TIME"}}"#;
            client.send(request).expect("sent");
            let start = clock.now();
            let texts = received(client.as_mut(), start + Duration::from_secs(3));
            assert_eq!(clock.now() - start, Duration::from_secs(3));
            texts
        };
        let texts = session();
        assert_eq!(texts, session());
        let count = |part: &str| texts.iter().filter(|text| text.contains(part)).count();
        assert_eq!((count("\"refs\":\"now\""), count("UAV-INF")), (1, 6), "{texts:?}");
    }

    #[test]
    fn a_client_that_stays_too_long_is_disconnected() {
        let clock = Clock::simulated();
        let stay = Some(Duration::from_secs(1));
        let server = InMemory::new(Options { stay, ..Options::default() }, &clock);
        let mut client = server.connect(&"tcp://memory:1".parse().expect("a URL")).expect("a client");
        let texts = received(client.as_mut(), clock.now() + Duration::from_secs(9));
        assert!(texts.last().is_some_and(|text| text.contains("SYS-CLOSE")), "{texts:?}");
        assert_eq!(client.receive(clock.now()).expect("an end"), Received::End);
        assert!(client.send(b"{}").is_err());
    }
}
