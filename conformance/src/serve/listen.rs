//! Connects sockets to the hub, with one thread per address, one per connection, and one for the simulation.

mod engine;
mod one_shot;
mod tcp;
mod udp;
mod web;

use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use self::engine::Sessions;
use super::family;
use super::hub::{ConnectionKind, Hub, SessionId, Sink};
use super::{Listening, Options, Transport};
use crate::flockwave::transport::http::is_silence;
use crate::rules::flockwave::FlockwaveRule;

/// The maximum number of concurrent connections. Each connection needs threads.
const CONNECTION_LIMIT: usize = 256;

/// The interval between simulation steps. Notifications are less frequent.
const TICK: Duration = Duration::from_millis(20);

/// The timeout of socket operations, after which a thread checks whether the server is shutting down.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// The interval between checks for new connections.
const ACCEPT_PAUSE: Duration = Duration::from_millis(5);

/// The write timeout, after which a client that doesn't read is disconnected.
const SEND_LIMIT: Duration = Duration::from_secs(10);

/// The time during which polling clients can still fetch the last messages. The next poll usually follows immediately.
const LAST_POLL: Duration = Duration::from_millis(500);

/// The time limit for connections to end.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);

/// The state that all threads share.
pub(super) struct Shared {
    hub: Mutex<Hub>,
    sessions: Sessions,
    bug: Option<&'static FlockwaveRule>,
    started: Instant,
    /// The time at which the server began to shut down.
    ending: OnceLock<Instant>,
    connections: AtomicUsize,
}

impl Shared {
    pub(super) fn new(options: Options, listening: &[Listening]) -> Self {
        let bug = options.bug;
        let mut hub = Hub::new(options, family::answer);
        hub.ports = listening
            .iter()
            .rev()
            .map(|location| (location.transport.name(), location.address.port()))
            .collect();
        Self {
            hub: Mutex::new(hub),
            sessions: Sessions::default(),
            bug,
            started: Instant::now(),
            ending: OnceLock::new(),
            connections: AtomicUsize::new(0),
        }
    }

    /// Stops all threads, and sends SYS-CLOSE to the clients.
    pub(super) fn end(&self) {
        self.ending.get_or_init(Instant::now);
        self.hub().end();
        self.sessions.end();
    }

    /// Waits until all connections have ended, up to a time limit.
    pub(super) fn wait_for_connections(&self) {
        let until = Instant::now() + SHUTDOWN_TIMEOUT;
        while self.connections.load(Ordering::Relaxed) > 0 && Instant::now() < until {
            thread::sleep(ACCEPT_PAUSE);
        }
    }

    fn is_ending(&self) -> bool {
        self.ending.get().is_some()
    }

    /// True if polling clients have had time to fetch the last messages.
    fn is_drained(&self) -> bool {
        self.ending.get().is_some_and(|ending| ending.elapsed() >= LAST_POLL)
    }

    /// The hub. A poisoned lock is ignored, since a panic doesn't leave the hub in an invalid state.
    fn hub(&self) -> MutexGuard<'_, Hub> {
        self.hub.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    fn has_bug(&self, rule: &FlockwaveRule) -> bool {
        self.bug.is_some_and(|bug| std::ptr::eq(bug, rule))
    }

    fn open(&self, kind: ConnectionKind, sink: Arc<dyn Sink>) -> SessionId {
        self.hub().open(kind, sink)
    }

    fn close(&self, id: SessionId) {
        self.hub().close(id);
    }

    fn receive(&self, id: SessionId, bytes: &[u8]) {
        self.hub().receive(id, bytes, self.elapsed());
    }
}

/// Starts the thread that advances the simulation.
pub(super) fn start_simulation(shared: &Arc<Shared>) -> JoinHandle<()> {
    let shared = Arc::clone(shared);
    thread::spawn(move || {
        while !shared.is_ending() {
            shared.hub().advance(shared.elapsed());
            shared.sessions.tend(&shared);
            thread::sleep(TICK);
        }
    })
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
        // The thread that accepts connections must also notice when the server ends.
        listener.set_nonblocking(true)?;
        Ok(Self { transport, address: listener.local_addr()?, socket: Socket::Stream(listener) })
    }

    pub(super) fn listening(&self) -> Listening {
        Listening { transport: self.transport, address: self.address }
    }

    pub(super) fn serve(self, shared: &Arc<Shared>) -> JoinHandle<()> {
        let shared = Arc::clone(shared);
        let transport = self.transport;
        thread::spawn(move || match self.socket {
            Socket::Datagram(socket) => udp::serve(&shared, &socket),
            Socket::Stream(listener) if transport == Transport::Tcp => {
                accept(&shared, &listener, tcp::serve_connection);
            }
            Socket::Stream(listener) => accept(&shared, &listener, web::serve_connection),
        })
    }
}

/// Accepts connections, and starts a thread for each.
fn accept(
    shared: &Arc<Shared>,
    listener: &TcpListener,
    serve_connection: fn(&Arc<Shared>, TcpStream) -> io::Result<()>,
) {
    while !shared.is_ending() {
        let stream = match listener.accept() {
            Ok((stream, _)) => stream,
            Err(error) => {
                // The server must survive an early client disconnect and a lack of file descriptors.
                thread::sleep(if is_silence(&error) { ACCEPT_PAUSE } else { POLL_INTERVAL });
                continue;
            }
        };
        let shared = Arc::clone(shared);
        if shared.connections.fetch_add(1, Ordering::Relaxed) >= CONNECTION_LIMIT {
            shared.connections.fetch_sub(1, Ordering::Relaxed);
            continue;
        }
        thread::spawn(move || {
            let _guard = ConnectionGuard(&shared);
            // On some systems, an accepted connection inherits the listener's non-blocking mode.
            if stream.set_nonblocking(false).is_ok() {
                // A connection's errors affect only its client.
                let _ = serve_connection(&shared, stream);
            }
        });
    }
}

/// Decrements the number of connections when a connection's thread ends.
struct ConnectionGuard<'s>(&'s Shared);

impl Drop for ConnectionGuard<'_> {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}
