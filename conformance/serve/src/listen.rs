//! Connects sockets to the hub. One thread serves all clients: it waits until a socket is ready, and then visits all
//! sockets in turn.

mod connection;
mod engine;
mod limits;
mod one_shot;
mod outbox;
mod reactor;
mod seats;
mod tcp;
mod udp;
mod web;

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::{TcpListener, TcpStream, UdpSocket};
use mio::{Interest, Poll, Token};
use uavspec_model::clock::Clock;
use uavspec_rules::flockwave::FlockwaveRule;

use self::engine::Sessions;
pub(super) use self::limits::REQUEST_LIMIT;
use self::limits::{Budget, Reason, TOTAL_QUEUED, TOTAL_RECEIVED};
use self::outbox::Outbox;
pub(super) use self::reactor::{Reactor, TICK};
use super::hub::{Hub, SessionId};
use super::{Counts, Listening, Transport};

/// The token of all sockets. They need no separate tokens, because events only wake the event loop.
const TOKEN: Token = Token(0);

/// The number of bytes to read from a stream in one step.
const PIECE: usize = 16 << 10;

/// The state that all connections share.
struct Shared {
    hub: Hub,
    sessions: Sessions,
    started: Instant,
    /// The memory of data that waits to be sent.
    queued: Rc<Budget>,
    /// The memory of received data.
    received: Rc<Budget>,
    /// The bytes that are being read from a stream.
    piece: Box<[u8]>,
    counts: Counts,
}

impl Shared {
    fn new(hub: Hub) -> Self {
        Self {
            started: hub.options.clock.now(),
            hub,
            sessions: Sessions::default(),
            queued: Budget::new(TOTAL_QUEUED),
            received: Budget::new(TOTAL_RECEIVED),
            piece: vec![0; PIECE].into(),
            counts: BTreeMap::new(),
        }
    }

    fn clock(&self) -> &Clock {
        &self.hub.options.clock
    }

    fn now(&self) -> Instant {
        self.clock().now()
    }

    /// The time since the start of the server.
    fn elapsed(&self) -> Duration {
        self.now().saturating_duration_since(self.started)
    }

    fn has_bug(&self, rule: &FlockwaveRule) -> bool {
        self.hub.has_bug(rule)
    }

    /// Creates a queue of data for a client.
    fn outbox(&self, stream: Option<Rc<TcpStream>>) -> Outbox {
        Outbox::new(stream, &self.queued, self.clock().clone())
    }

    /// Processes a message. Returns true if it is a valid request.
    fn receive(&mut self, id: SessionId, bytes: &[u8]) -> bool {
        let elapsed = self.elapsed();
        self.hub.receive(id, bytes, elapsed)
    }

    /// Counts a client that the server refused or disconnected.
    fn count(&mut self, reason: Reason) {
        if let Some(reason) = reason {
            *self.counts.entry(reason).or_default() += 1;
        }
    }
}

/// Bound sockets, registered for events.
pub(super) struct Sockets {
    poll: Poll,
    /// The sockets that accept connections.
    doors: Vec<(TcpListener, Transport)>,
    datagrams: Vec<UdpSocket>,
    /// The addresses of the sockets, in the requested order.
    pub(super) listening: Vec<Listening>,
}

impl Sockets {
    /// Binds these addresses.
    pub(super) fn bind(addresses: &[(Transport, SocketAddr)]) -> io::Result<Self> {
        let (doors, datagrams, listening) = (Vec::new(), Vec::new(), Vec::new());
        let mut sockets = Self { poll: Poll::new()?, doors, datagrams, listening };
        for (transport, address) in addresses {
            let address = sockets.add(*transport, *address).map_err(|error| {
                let place = format!("{}://{address}", transport.name());
                io::Error::new(error.kind(), format!("can't listen on {place}: {error}"))
            })?;
            sockets.listening.push(Listening { transport: *transport, address });
        }
        Ok(sockets)
    }

    /// Binds an address. Returns it with the actual port.
    fn add(&mut self, transport: Transport, address: SocketAddr) -> io::Result<SocketAddr> {
        if transport == Transport::Udp {
            let mut socket = UdpSocket::bind(address)?;
            self.poll.registry().register(&mut socket, TOKEN, Interest::READABLE)?;
            let address = socket.local_addr();
            self.datagrams.push(socket);
            address
        } else {
            let mut listener = TcpListener::bind(address)?;
            self.poll.registry().register(&mut listener, TOKEN, Interest::READABLE)?;
            let address = listener.local_addr();
            self.doors.push((listener, transport));
            address
        }
    }
}
