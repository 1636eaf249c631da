//! Connects sockets to the hub. One thread serves all clients: it waits for events of all sockets, and visits the
//! connections that have something to do. The connection that used the least computing time comes first, so clients that
//! send many requests can't delay others.

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

use self::engine::Sessions;
use self::limits::{Budget, TOTAL_QUEUED, TOTAL_RECEIVED};
pub(super) use self::reactor::{Control, Reactor};
use self::statistics::Statistics;
use super::family;
use super::hub::{Hub, SessionId};
use super::{Listening, Options, Transport};
use crate::rules::flockwave::FlockwaveRule;

/// The maximum computing time of a connection or socket before others have their turn. A request that began earlier is
/// completed.
const SLICE: Duration = Duration::from_millis(1);

/// The state that all connections share.
struct Shared {
    hub: Hub,
    sessions: Sessions,
    bug: Option<&'static FlockwaveRule>,
    started: Instant,
    /// The memory of data that waits to be sent.
    queued: Rc<Budget>,
    /// The memory of received data.
    received: Rc<Budget>,
    statistics: Statistics,
}

impl Shared {
    fn new(options: Options, listening: &[Listening]) -> Self {
        let bug = options.bug;
        let mut hub = Hub::new(options, family::answer);
        hub.ports = listening
            .iter()
            .rev()
            .map(|location| (location.transport.name(), location.address.port()))
            .collect();
        Self {
            hub,
            sessions: Sessions::default(),
            bug,
            started: Instant::now(),
            queued: Budget::new(TOTAL_QUEUED),
            received: Budget::new(TOTAL_RECEIVED),
            statistics: Statistics::default(),
        }
    }

    fn has_bug(&self, rule: &FlockwaveRule) -> bool {
        self.bug.is_some_and(|bug| std::ptr::eq(bug, rule))
    }

    /// Processes a message. Returns true if it is a valid request.
    fn receive(&mut self, id: SessionId, bytes: &[u8]) -> bool {
        self.hub.receive(id, bytes, self.started.elapsed())
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
        if transport == Transport::Udp {
            let socket = UdpSocket::bind(address).map_err(explain)?;
            return Ok(Self { transport, address: socket.local_addr()?, socket: Socket::Datagram(socket) });
        }
        let listener = TcpListener::bind(address).map_err(explain)?;
        Ok(Self { transport, address: listener.local_addr()?, socket: Socket::Stream(listener) })
    }

    pub(super) fn listening(&self) -> Listening {
        Listening { transport: self.transport, address: self.address }
    }
}
