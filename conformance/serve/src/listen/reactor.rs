//! The event loop of the server.

use std::io::ErrorKind::{ConnectionAborted, Interrupted, WouldBlock};
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use mio::net::TcpStream;
use mio::{Events, Interest};
use uavspec_flockwave::transport::http::Response;
use uavspec_model::clock::Clock;

use super::connection::Connection;
use super::limits::{NOT_ACCEPTED, REFUSED, REPLACED, STEPS_AT_ONCE, connections};
use super::seats::{Admission, admit};
use super::udp::Datagrams;
use super::{Counts, Hub, Shared, Sockets, TOKEN, Transport, engine};
use crate::hub::farewell;
use crate::message::{enveloped, text};

/// The interval between simulation steps. Notifications are less frequent.
pub(crate) const TICK: Duration = Duration::from_millis(20);

/// The time during which clients can receive the last messages, in real time, because simulated time may stand still. The
/// next poll of a polling client usually follows immediately.
const LAST_TIME: Duration = Duration::from_millis(500);

/// The time during which clients that read slowly can receive the last messages.
const MAX_LAST_TIME: Duration = Duration::from_secs(2);

/// The event loop. Whenever a socket is ready, the loop visits all sockets, until none of them has anything to do. A socket
/// that isn't ready costs only a system call, and there are few sockets.
pub(crate) struct Reactor {
    shared: Shared,
    sockets: Sockets,
    datagrams: Vec<Datagrams>,
    connections: Vec<Connection>,
    /// The maximum number of connections.
    limit: usize,
    /// The time from which connections are accepted again after an error.
    accepts_from: Instant,
}

impl Reactor {
    /// Creates an event loop.
    pub(crate) fn new(mut sockets: Sockets, hub: Hub) -> Self {
        let datagrams = sockets.datagrams.drain(..).map(Datagrams::new).collect();
        let (shared, limit) = (Shared::new(hub), connections());
        let accepts_from = shared.now();
        Self { shared, sockets, datagrams, connections: Vec::new(), limit, accepts_from }
    }

    /// Serves all clients until the end is requested. Returns the counts of refused and disconnected clients.
    pub(crate) fn run(mut self, is_ending: &AtomicBool) -> Counts {
        let mut next_tick = self.shared.now();
        let mut is_busy = false;
        while !is_ending.load(Ordering::Acquire) {
            self.wait(if is_busy { Duration::ZERO } else { self.shared.clock().left(next_tick).min(TICK) });
            if self.shared.now() >= next_tick {
                next_tick = self.shared.now() + TICK;
                self.tick();
            }
            is_busy = self.turn();
        }
        self.end();
        self.shared.counts
    }

    /// Closes all connections, and waits until the clients have received the last messages.
    fn end(&mut self) {
        self.sockets.doors.clear();
        self.shared.hub.end();
        engine::close(&self.shared);
        let start = Clock::real().now();
        while !self.connections.is_empty() {
            let is_sending = self.connections.iter().any(Connection::is_sending);
            let limit = if is_sending { MAX_LAST_TIME } else { LAST_TIME };
            if Clock::real().now() >= start + limit {
                break;
            }
            let is_busy = self.turn();
            self.wait(if is_busy { Duration::ZERO } else { TICK });
        }
    }

    /// Waits for an event of any socket.
    fn wait(&mut self, time: Duration) {
        if self.sockets.poll.poll(&mut Events::with_capacity(64), Some(time)).is_err() {
            Clock::real().sleep(TICK);
        }
    }

    /// Advances the simulation, and checks the time limits of sessions and of clients over UDP.
    fn tick(&mut self) {
        let elapsed = self.shared.elapsed();
        self.shared.hub.advance(elapsed);
        engine::tend(&mut self.shared);
        for datagrams in &mut self.datagrams {
            datagrams.close_expired(&mut self.shared);
        }
    }

    /// Visits all sockets. Returns true if anything happened, so there may be more to do.
    fn turn(&mut self) -> bool {
        let mut is_busy = self.accept();
        for datagrams in &mut self.datagrams {
            is_busy |= datagrams.receive(&mut self.shared);
        }
        let shared = &mut self.shared;
        self.connections.retain_mut(|connection| match connection.visit(shared) {
            Ok(has_advanced) => {
                is_busy |= has_advanced;
                true
            }
            Err(reason) => {
                connection.end(shared, reason);
                false
            }
        });
        is_busy
    }

    /// Accepts waiting connections. Returns true if there were any.
    fn accept(&mut self) -> bool {
        if self.shared.now() < self.accepts_from {
            return false;
        }
        let mut has_accepted = false;
        for door in 0..self.sockets.doors.len() {
            for _ in 0..STEPS_AT_ONCE {
                let (listener, transport) = &self.sockets.doors[door];
                let transport = *transport;
                match listener.accept() {
                    Ok((stream, _)) => self.admit(stream, transport),
                    Err(error) if matches!(error.kind(), WouldBlock | ConnectionAborted | Interrupted) => {
                        break;
                    }
                    // The system lacks memory or file descriptors. Other sockets are served in the meantime.
                    Err(_) => {
                        self.shared.count(NOT_ACCEPTED);
                        self.accepts_from = self.shared.now() + TICK;
                        break;
                    }
                }
                has_accepted = true;
            }
        }
        has_accepted
    }

    /// Serves a new connection. If there are too many, closes another one in its place, or refuses the new one.
    fn admit(&mut self, mut stream: TcpStream, transport: Transport) {
        let seats = self.connections.iter().map(|connection| connection.seat).enumerate();
        match admit(seats, self.limit, self.shared.now()) {
            Admission::Free => {}
            Admission::Evict(at) => self.connections.remove(at).end(&mut self.shared, REPLACED),
            Admission::Refused => {
                self.shared.count(REFUSED);
                refuse(&stream, transport);
                return;
            }
        }
        let interest = Interest::READABLE | Interest::WRITABLE;
        let is_usable = stream
            .set_nodelay(true)
            .and_then(|()| self.sockets.poll.registry().register(&mut stream, TOKEN, interest));
        if is_usable.is_err() {
            return self.shared.count(NOT_ACCEPTED);
        }
        self.connections.push(Connection::new(&mut self.shared, stream, transport));
    }
}

/// Sends the reason to a client that the server refuses because it is full, if sending is possible immediately.
fn refuse(mut stream: &TcpStream, transport: Transport) {
    const REASON: &str = "the server is full";
    let bytes = match transport {
        Transport::Tcp => (enveloped("s1", None, &text(&farewell(REASON))) + "\n").into_bytes(),
        _ => Response::refusal("503 Service Unavailable", REASON).to_bytes(None),
    };
    // The connection ends anyway.
    let _ = stream.write_all(&bytes);
}
