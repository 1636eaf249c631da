//! The event loop of the server.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use mio::event::{Event, Source};
use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token};
use uavspec_model::clock::Clock;

use super::connection::{Connection, Visit};
use super::limits::{IDLE_TIME, connections};
use super::seats::{Admission, Seats};
use super::statistics::{Reason, Statistics};
use super::tcp::LineClient;
use super::udp::Datagrams;
use super::web::WebClient;
use super::{Bound, Hub, Shared, Socket, Transport, engine};

/// The interval between simulation steps. Notifications are less frequent.
const TICK: Duration = Duration::from_millis(20);

/// The interval between checks of time limits.
const SWEEP: Duration = Duration::from_millis(200);

/// The maximum number of connections to accept before connected clients have their turn.
const ACCEPTS_AT_ONCE: usize = 16;

/// The time during which polling clients can still fetch the last messages. The next poll usually follows immediately.
const LAST_POLL: Duration = Duration::from_millis(500);

/// The time limit for connections to end.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);

/// The connection between the event loop and the thread that started it.
#[derive(Debug, Default)]
pub(crate) struct Control {
    is_ending: AtomicBool,
    statistics: Mutex<Statistics>,
}

impl Control {
    /// Requests the end of the event loop.
    pub(crate) fn end(&self) {
        self.is_ending.store(true, Ordering::Release);
    }

    /// The counts of clients.
    pub(crate) fn statistics(&self) -> Statistics {
        *self.statistics.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A socket that accepts connections.
struct Door {
    listener: TcpListener,
    transport: Transport,
    /// True if connections may be waiting.
    is_ready: bool,
    /// The time before which no connection is accepted, because the system reported an error.
    pause: Option<Instant>,
}

/// The event loop.
pub(crate) struct Reactor {
    shared: Shared,
    poll: Poll,
    doors: BTreeMap<Token, Door>,
    datagrams: BTreeMap<Token, Datagrams>,
    /// The datagram sockets that may have waiting datagrams.
    ready_datagrams: BTreeSet<Token>,
    connections: BTreeMap<Token, Connection>,
    /// The connections to visit.
    ready: BTreeSet<Token>,
    /// The connections that wait for a response.
    waiting: BTreeSet<Token>,
    seats: Seats<Token>,
    next_token: usize,
    /// The real time at which the end was requested, because simulated time may stand still.
    ending: Option<Instant>,
}

impl Reactor {
    /// Registers sockets for events.
    pub(crate) fn register(poll: &Poll, bound: &mut [Bound]) -> io::Result<()> {
        for (token, bound) in bound.iter_mut().enumerate() {
            let source: &mut dyn Source = match &mut bound.socket {
                Socket::Datagram(socket) => socket,
                Socket::Stream(listener) => listener,
            };
            poll.registry().register(source, Token(token), Interest::READABLE)?;
        }
        Ok(())
    }

    /// Creates an event loop for registered sockets.
    pub(crate) fn new(poll: Poll, bound: Vec<Bound>, hub: Hub) -> Self {
        let mut reactor = Self {
            shared: Shared::new(hub),
            poll,
            doors: BTreeMap::new(),
            datagrams: BTreeMap::new(),
            ready_datagrams: BTreeSet::new(),
            connections: BTreeMap::new(),
            ready: BTreeSet::new(),
            waiting: BTreeSet::new(),
            seats: Seats::new(connections(), IDLE_TIME),
            next_token: 0,
            ending: None,
        };
        for bound in bound {
            let token = reactor.token();
            match bound.socket {
                Socket::Datagram(socket) => {
                    reactor.datagrams.insert(token, Datagrams::new(socket));
                }
                Socket::Stream(listener) => {
                    let door = Door { listener, transport: bound.transport, is_ready: true, pause: None };
                    reactor.doors.insert(token, door);
                }
            }
        }
        reactor
    }

    /// A token that has never been used.
    fn token(&mut self) -> Token {
        self.next_token += 1;
        Token(self.next_token - 1)
    }

    /// Serves all clients until the end is requested.
    pub(crate) fn run(mut self, control: &Control) {
        let mut events = Events::with_capacity(1024);
        let (mut next_tick, mut next_sweep) = (self.shared.now(), self.shared.now());
        while !self.is_done() {
            let is_busy = !self.ready.is_empty() || !self.ready_datagrams.is_empty() || self.can_accept();
            let wait = if is_busy { Duration::ZERO } else { self.shared.clock.left(next_tick).min(TICK) };
            if let Err(error) = self.poll.poll(&mut events, Some(wait))
                && error.kind() != ErrorKind::Interrupted
            {
                Clock::real().sleep(TICK);
            }
            for event in &events {
                self.note(event);
            }
            self.accept();
            self.receive_datagrams();
            self.wake_answered();
            self.visit_ready();
            self.end_if_requested(control);
            if self.shared.now() >= next_tick {
                next_tick = self.shared.now() + TICK;
                self.tick();
            }
            if self.shared.now() >= next_sweep {
                next_sweep = self.shared.now() + SWEEP;
                self.sweep();
            }
            self.publish(control);
        }
        self.publish(control);
    }

    /// True if the server is ending, and all connections have ended or exceeded the time limit.
    fn is_done(&self) -> bool {
        let is_over = |ending: Instant| Clock::real().now() >= ending + SHUTDOWN_TIMEOUT;
        self.ending.is_some_and(|ending| self.connections.is_empty() || is_over(ending))
    }

    /// Closes all connections if the end is requested, at any time.
    fn end_if_requested(&mut self, control: &Control) {
        if self.ending.is_none() && control.is_ending.load(Ordering::Acquire) {
            self.ending = Some(Clock::real().now());
            self.shared.hub.end();
            self.shared.sessions.end();
            self.ready.extend(self.connections.keys());
        }
    }

    /// Advances the simulation.
    fn tick(&mut self) {
        if self.ending.is_none() {
            let elapsed = self.shared.elapsed();
            self.shared.hub.advance(elapsed);
        }
    }

    /// Publishes the counts of clients.
    fn publish(&mut self, control: &Control) {
        self.shared.statistics.open = self.connections.len();
        *control.statistics.lock().unwrap_or_else(PoisonError::into_inner) = self.shared.statistics;
    }

    /// Checks all time limits.
    fn sweep(&mut self) {
        let now = self.shared.now();
        if self.ending.is_none() {
            engine::tend(&mut self.shared);
        }
        for datagrams in self.datagrams.values_mut() {
            datagrams.close_expired(&mut self.shared);
        }
        let is_drained = self.ending.is_some_and(|ending| Clock::real().now() >= ending + LAST_POLL);
        let overdue: Vec<(Token, Reason)> = self
            .connections
            .iter()
            .filter_map(|(token, connection)| {
                let is_unneeded = is_drained && !connection.is_closed();
                let reason = connection.overdue(now).or(is_unneeded.then_some(Reason::Disconnected));
                reason.map(|reason| (*token, reason))
            })
            .collect();
        for (token, reason) in overdue {
            self.end(token, reason);
        }
        // Sessions and notifications may have closed connections.
        self.wake_closed();
    }

    /// Makes all connections ready that the server has closed.
    fn wake_closed(&mut self) {
        let closed = self.connections.iter().filter(|(_, connection)| connection.is_closed());
        let closed = closed.map(|(token, _)| *token);
        self.ready.extend(closed);
    }

    fn note(&mut self, event: &Event) {
        let token = event.token();
        if let Some(door) = self.doors.get_mut(&token) {
            door.is_ready = true;
        } else if self.datagrams.contains_key(&token) {
            self.ready_datagrams.insert(token);
        } else if event.is_error() || event.is_read_closed() && event.is_write_closed() {
            self.hang_up(token);
        } else {
            self.ready.insert(token);
        }
    }

    /// Handles the end of a connection that can't send or receive anything more. Received requests are still processed.
    fn hang_up(&mut self, token: Token) {
        if self.waiting.contains(&token) {
            self.end(token, Reason::Disconnected);
        } else {
            self.ready.insert(token);
        }
    }

    /// True if connections may be waiting that can be accepted now.
    fn can_accept(&self) -> bool {
        let now = self.shared.now();
        self.doors.values().any(|door| door.is_ready && door.pause.is_none_or(|until| now >= until))
    }

    /// Accepts waiting connections.
    fn accept(&mut self) {
        if self.ending.is_some() {
            self.doors.clear();
        }
        let tokens: Vec<Token> = self.doors.keys().copied().collect();
        for token in tokens {
            for _ in 0..ACCEPTS_AT_ONCE {
                let Some((stream, transport)) = self.accept_one(token) else { break };
                self.admit(stream, transport);
            }
        }
    }

    fn accept_one(&mut self, token: Token) -> Option<(TcpStream, Transport)> {
        let door = self.doors.get_mut(&token)?;
        let now = self.shared.now();
        if !door.is_ready || door.pause.is_some_and(|until| now < until) {
            return None;
        }
        door.pause = None;
        match door.listener.accept() {
            Ok((stream, _)) => Some((stream, door.transport)),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                door.is_ready = false;
                None
            }
            // The client has disconnected already.
            Err(error) if matches!(error.kind(), ErrorKind::ConnectionAborted | ErrorKind::Interrupted) => {
                None
            }
            // The system lacks memory or file descriptors. Other sockets are served in the meantime.
            Err(_) => {
                self.shared.statistics.failed += 1;
                door.pause = Some(now + TICK);
                None
            }
        }
    }

    /// Serves a new connection. If there are too many, another connection gives way, or the new one is refused.
    fn admit(&mut self, mut stream: TcpStream, transport: Transport) {
        let now = self.shared.now();
        match self.seats.admit(now) {
            Admission::Free => {}
            Admission::Evict(token) => self.end(token, Reason::Replaced),
            Admission::Refused => {
                self.shared.statistics.refused += 1;
                refuse(&stream, transport);
                return;
            }
        }
        let token = self.token();
        let interest = Interest::READABLE | Interest::WRITABLE;
        let is_usable = stream
            .set_nodelay(true)
            .and_then(|()| self.poll.registry().register(&mut stream, token, interest));
        if is_usable.is_err() {
            self.shared.statistics.failed += 1;
            return;
        }
        let connection = Connection::new(&mut self.shared, stream, |shared, outbox| match transport {
            Transport::Tcp => Box::new(LineClient::new(shared, outbox)),
            _ => Box::new(WebClient::new()),
        });
        self.shared.statistics.accepted += 1;
        self.seats.insert(token, now);
        self.connections.insert(token, connection);
        self.ready.insert(token);
    }

    fn receive_datagrams(&mut self) {
        for token in std::mem::take(&mut self.ready_datagrams) {
            if let Some(datagrams) = self.datagrams.get_mut(&token)
                && datagrams.receive(&mut self.shared)
            {
                self.ready_datagrams.insert(token);
            }
        }
    }

    /// Makes the connections ready whose response may be available. Any request or simulation step may have caused it.
    fn wake_answered(&mut self) {
        let is_due = |token: &Token| self.connections.get(token).is_some_and(Connection::is_due);
        let answered: Vec<Token> = self.waiting.iter().copied().filter(is_due).collect();
        for token in answered {
            self.waiting.remove(&token);
            self.ready.insert(token);
        }
    }

    /// Visits each connection that has something to do.
    fn visit_ready(&mut self) {
        for token in std::mem::take(&mut self.ready) {
            self.visit(token);
        }
    }

    fn visit(&mut self, token: Token) {
        let Some(connection) = self.connections.get_mut(&token) else { return };
        let now = self.shared.now();
        let visit = connection.visit(&mut self.shared);
        if connection.has_requested() {
            self.seats.touch(&token, true, now);
        }
        match visit {
            Visit::Again => _ = self.ready.insert(token),
            Visit::Waiting => _ = self.waiting.insert(token),
            Visit::Rest => {}
            Visit::End(reason) => self.end(token, reason),
        }
    }

    /// Ends a connection.
    fn end(&mut self, token: Token, reason: Reason) {
        self.seats.remove(&token);
        self.waiting.remove(&token);
        self.ready.remove(&token);
        let Some(connection) = self.connections.remove(&token) else { return };
        self.shared.statistics.count(reason);
        connection.end(&mut self.shared, reason);
    }
}

/// Sends the reason to a client that the server refuses because it is full, if sending is possible immediately.
fn refuse(mut stream: &TcpStream, transport: Transport) {
    const REASON: &str = "the server is full";
    let text = match transport {
        Transport::Tcp => format!(
            "{{\"$fw.version\":\"1.0\",\"id\":\"s1\",\"body\":{{\"type\":\"SYS-CLOSE\",\"reason\":\"{REASON}\"}}}}\n"
        ),
        _ => format!(
            "HTTP/1.1 503 Service Unavailable\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{REASON}\n",
            REASON.len() + 1
        ),
    };
    // The connection ends anyway.
    let _ = stream.write_all(text.as_bytes());
}
