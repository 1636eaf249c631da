//! Connects sockets to the hub. One thread serves all clients: it waits for events of all sockets, and visits the
//! connections that have something to do in turn.

mod connection;
mod engine;
pub(crate) mod limits;
mod one_shot;
mod outbox;
mod reactor;
mod reply;
mod seats;
pub(super) mod statistics;
mod tcp;
mod udp;
mod web;

use std::io;
use std::net::SocketAddr;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mio::net::{TcpListener, UdpSocket};
use uavspec_model::clock::Clock;
use uavspec_rules::flockwave::FlockwaveRule;

use self::engine::Sessions;
use self::limits::{Budget, TOTAL_QUEUED, TOTAL_RECEIVED};
pub(super) use self::reactor::{Control, Reactor};
use self::statistics::Statistics;
use super::hub::{Hub, SessionId};
use super::{Listening, Transport};

/// The state that all connections share.
struct Shared {
    hub: Hub,
    sessions: Sessions,
    bug: Option<&'static FlockwaveRule>,
    clock: Clock,
    started: Instant,
    /// The memory of data that waits to be sent.
    queued: Rc<Budget>,
    /// The memory of received data.
    received: Rc<Budget>,
    statistics: Statistics,
}

impl Shared {
    fn new(hub: Hub) -> Self {
        let (bug, clock) = (hub.options.bug, hub.options.clock.clone());
        Self {
            hub,
            sessions: Sessions::default(),
            bug,
            started: clock.now(),
            clock,
            queued: Budget::new(TOTAL_QUEUED),
            received: Budget::new(TOTAL_RECEIVED),
            statistics: Statistics::default(),
        }
    }

    fn now(&self) -> Instant {
        self.clock.now()
    }

    /// The time since the start of the server.
    fn elapsed(&self) -> Duration {
        self.now().saturating_duration_since(self.started)
    }

    fn has_bug(&self, rule: &FlockwaveRule) -> bool {
        self.bug.is_some_and(|bug| std::ptr::eq(bug, rule))
    }

    /// Processes a message. Returns true if it is a valid request.
    fn receive(&mut self, id: SessionId, bytes: &[u8]) -> bool {
        let elapsed = self.elapsed();
        self.hub.receive(id, bytes, elapsed)
    }
}

/// A bound address.
pub(super) struct Bound {
    transport: Transport,
    address: SocketAddr,
    socket: Socket,
}

enum Socket {
    Stream(TcpListener),
    Datagram(UdpSocket),
}

impl Bound {
    pub(super) fn bind(transport: Transport, address: SocketAddr) -> io::Result<Self> {
        let explain = |error: io::Error| {
            io::Error::new(error.kind(), format!("can't listen on {}://{address}: {error}", transport.name()))
        };
        Ok(if transport == Transport::Udp {
            let socket = UdpSocket::bind(address).map_err(explain)?;
            Self { transport, address: socket.local_addr()?, socket: Socket::Datagram(socket) }
        } else {
            let listener = TcpListener::bind(address).map_err(explain)?;
            Self { transport, address: listener.local_addr()?, socket: Socket::Stream(listener) }
        })
    }

    pub(super) fn listening(&self) -> Listening {
        Listening { transport: self.transport, address: self.address }
    }
}
