//! Networks in memory. If the clock is simulated, probes over these networks take no real time.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::rc::Rc;
use std::time::{Duration, Instant};

use uavspec_flockwave::transport::{Client, Endpoint, Network, Received};
use uavspec_model::clock::Clock;

use crate::proxy::Pass;

type Watch = Rc<dyn Fn(&[u8]) -> Pass>;

type Hears = Rc<dyn Fn(&[u8]) -> bool>;

/// A network that passes requests and messages to functions, which decide whether they arrive.
pub struct Watched<N> {
    /// The network.
    pub network: N,
    /// Decides which requests are forwarded.
    pub watch: Watch,
    /// Returns true for messages from the server that arrive.
    pub hears: Hears,
}

impl<N> Watched<N> {
    /// Watches the requests that clients send.
    pub fn new(network: N, watch: impl Fn(&[u8]) -> Pass + 'static) -> Self {
        Self { network, watch: Rc::new(watch), hears: Rc::new(|_| true) }
    }
}

/// A client of a watched network.
struct WatchedClient {
    client: Box<dyn Client>,
    watch: Watch,
    hears: Hears,
    is_cut: bool,
}

impl<N: Network> Network for Watched<N> {
    fn connect(&self, endpoint: &Endpoint) -> io::Result<Box<dyn Client>> {
        let client = self.network.connect(endpoint)?;
        let (watch, hears) = (Rc::clone(&self.watch), Rc::clone(&self.hears));
        Ok(Box::new(WatchedClient { client, watch, hears, is_cut: false }))
    }
}

impl Client for WatchedClient {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        let pass = if self.is_cut { Pass::Cut } else { (self.watch)(message) };
        self.is_cut |= pass == Pass::Cut;
        if pass == Pass::Forward { self.client.send(message) } else { Ok(()) }
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.client.send_raw(bytes)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            match if self.is_cut { Received::End } else { self.client.receive(until)? } {
                Received::Message(bytes) if !(self.hears)(&bytes) => {}
                received => return Ok(received),
            }
        }
    }
}

/// An event that the client of a scripted server receives.
#[derive(Clone, Debug)]
enum Event {
    Bytes(Vec<u8>),
    /// The operating system's report that a datagram reached no server.
    Refused,
    End,
}

/// The server's end of a connection, to which a script writes.
pub struct Line {
    clock: Clock,
    /// The number of the connection, from 0.
    pub number: usize,
    /// The time after which the server closes the connection if it is idle.
    pub idle_limit: Option<Duration>,
    /// The start of an incomplete line from the client.
    partial: Vec<u8>,
    /// The time of the latest segment.
    active_at: Instant,
    queues: Queues,
}

/// The pending events of all open connections, by connection number. Each event has a time.
type Queues = Rc<RefCell<BTreeMap<usize, Vec<(Instant, Event)>>>>;

impl Line {
    /// The lines that are complete after a segment.
    pub fn lines(&mut self, segment: &[u8]) -> Vec<u8> {
        self.partial.extend(segment);
        let end = self.partial.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        self.partial.drain(..end).collect()
    }

    /// Sends bytes.
    pub fn send(&self, bytes: impl AsRef<[u8]>) {
        self.send_after(Duration::ZERO, bytes);
    }

    /// Sends bytes after a delay, which starts when everything sent before has arrived.
    pub fn send_after(&self, delay: Duration, bytes: impl AsRef<[u8]>) {
        self.push(self.number, delay, Event::Bytes(bytes.as_ref().to_vec()));
    }

    /// Reports to the client that no server receives its datagrams.
    pub fn refuse(&self) {
        self.push(self.number, Duration::ZERO, Event::Refused);
    }

    /// Closes the connection with this number, which may be another connection.
    pub fn end(&self, number: usize) {
        self.push(number, Duration::ZERO, Event::End);
    }

    fn push(&self, number: usize, delay: Duration, event: Event) {
        if let Some(queue) = self.queues.borrow_mut().get_mut(&number) {
            let now = self.clock.now();
            let last = queue.last().map_or(now, |(at, _)| *at);
            queue.push((last.max(now) + delay, event));
        }
    }
}

/// A server that handles each client with a script. The script is a function that is called with the connection and
/// each segment that arrives. When a connection starts, it is called with an empty segment.
pub struct Scripted<S> {
    clock: Clock,
    script: Rc<S>,
    queues: Queues,
    connections: RefCell<usize>,
    /// The maximum number of accepted connections.
    limit: usize,
}

impl<S: Fn(&mut Line, &[u8])> Scripted<S> {
    /// A network whose server follows a script.
    pub fn new(clock: &Clock, script: S) -> Self {
        let (clock, script) = (clock.clone(), Rc::new(script));
        Self { clock, script, queues: Rc::default(), connections: RefCell::new(0), limit: usize::MAX }
    }

    /// Accepts this number of connections, and refuses all further ones.
    #[must_use]
    pub fn accepting(self, limit: usize) -> Self {
        Self { limit, ..self }
    }
}

impl<S: Fn(&mut Line, &[u8]) + 'static> Network for Scripted<S> {
    fn connect(&self, _: &Endpoint) -> io::Result<Box<dyn Client>> {
        let number = *self.connections.borrow();
        if number >= self.limit {
            return Err(ErrorKind::ConnectionRefused.into());
        }
        *self.connections.borrow_mut() += 1;
        self.queues.borrow_mut().insert(number, Vec::new());
        let (clock, queues) = (self.clock.clone(), Rc::clone(&self.queues));
        let active_at = clock.now();
        let mut line = Line { clock, number, idle_limit: None, partial: Vec::new(), active_at, queues };
        (self.script)(&mut line, b"");
        Ok(Box::new(ScriptedClient { line, script: Rc::clone(&self.script), rest: Vec::new() }))
    }
}

struct ScriptedClient<S> {
    line: Line,
    script: Rc<S>,
    /// The start of an incomplete line from the server.
    rest: Vec<u8>,
}

impl<S: Fn(&mut Line, &[u8])> ScriptedClient<S> {
    /// Returns the next event that is due by `until`. The end of the connection stays in the queue.
    fn next(&self, until: Instant) -> Option<(Instant, Event)> {
        let idle_at = self.line.idle_limit.map(|limit| self.line.active_at + limit);
        let mut queues = self.line.queues.borrow_mut();
        let queue = queues.get_mut(&self.line.number)?;
        let (at, event) = queue
            .first()
            .cloned()
            .into_iter()
            .chain(idle_at.map(|at| (at, Event::End)))
            .min_by_key(|(at, _)| *at)?;
        if at > until {
            return None;
        }
        if !matches!(event, Event::End) {
            queue.remove(0);
        }
        Some((at, event))
    }

    fn is_ended(&self) -> bool {
        let now = self.line.clock.now();
        let is_end = self.line.queues.borrow()[&self.line.number]
            .first()
            .is_some_and(|(at, event)| *at <= now && matches!(event, Event::End));
        is_end || self.line.idle_limit.is_some_and(|limit| self.line.active_at + limit <= now)
    }
}

impl<S: Fn(&mut Line, &[u8])> Client for ScriptedClient<S> {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        self.send_raw(&[message, b"\n"].concat())
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.is_ended() {
            return Err(ErrorKind::BrokenPipe.into());
        }
        self.line.active_at = self.line.clock.now();
        (self.script)(&mut self.line, bytes);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        loop {
            if let Some(end) = self.rest.iter().position(|byte| *byte == b'\n') {
                let mut line: Vec<u8> = self.rest.drain(..=end).collect();
                line.pop();
                return Ok(Received::Message(line));
            }
            let Some((at, event)) = self.next(until) else {
                self.line.clock.sleep_until(until);
                return Ok(Received::Silence);
            };
            self.line.clock.sleep_until(at);
            match event {
                Event::Bytes(bytes) => self.rest.extend(bytes),
                Event::Refused => return Err(ErrorKind::ConnectionRefused.into()),
                Event::End => return Ok(Received::End),
            }
        }
    }
}

impl<S> Drop for ScriptedClient<S> {
    fn drop(&mut self) {
        self.line.queues.borrow_mut().remove(&self.line.number);
    }
}
