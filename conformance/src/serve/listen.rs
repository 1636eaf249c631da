//! What stands between sockets and the hub: a thread for each address, one for each connection, and one for the time.

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

/// How many connections there may be at a time. Each takes threads.
const CONNECTION_LIMIT: usize = 256;

/// How often the simulation goes on. Nothing that clients are told of changes faster.
const TICK: Duration = Duration::from_millis(20);

/// How long whoever waits for a socket looks away from it.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// How often it is seen whether somebody connects.
const ACCEPT_PAUSE: Duration = Duration::from_millis(5);

/// How long a client may take none of what is sent to it.
const SEND_LIMIT: Duration = Duration::from_secs(10);

/// How long clients may poll for the last time. The next poll mostly follows the last one at once.
const LAST_POLL: Duration = Duration::from_millis(500);

/// How long connections have to end.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);

/// What all threads share.
pub(super) struct Shared {
    hub: Mutex<Hub>,
    sessions: Sessions,
    bug: Option<&'static FlockwaveRule>,
    started: Instant,
    /// When it began to end.
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

    /// Tells all threads to end, and says farewell.
    pub(super) fn end(&self) {
        self.ending.get_or_init(Instant::now);
        self.hub().end();
        self.sessions.end();
    }

    /// Waits until connections have ended, but not for ever.
    pub(super) fn wait_for_connections(&self) {
        let until = Instant::now() + SHUTDOWN_TIMEOUT;
        while self.connections.load(Ordering::Relaxed) > 0 && Instant::now() < until {
            thread::sleep(ACCEPT_PAUSE);
        }
    }

    fn is_ending(&self) -> bool {
        self.ending.get().is_some()
    }

    /// Whether clients that poll have had time to fetch the farewell.
    fn has_ended(&self) -> bool {
        self.ending.get().is_some_and(|ending| ending.elapsed() >= LAST_POLL)
    }

    /// The hub. What a thread left that panicked is as good as anything else: it has no state that is half done for long.
    fn hub(&self) -> MutexGuard<'_, Hub> {
        self.hub.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    fn has_bug(&self, of: &FlockwaveRule) -> bool {
        self.bug.is_some_and(|bug| std::ptr::eq(bug, of))
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

/// Lets the simulation go on.
pub(super) fn keep_time(shared: &Arc<Shared>) -> JoinHandle<()> {
    let shared = Arc::clone(shared);
    thread::spawn(move || {
        while !shared.is_ending() {
            shared.hub().advance(shared.elapsed());
            shared.sessions.tend(&shared);
            thread::sleep(TICK);
        }
    })
}

/// An address that is listened at.
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
            io::Error::new(
                error.kind(),
                format!("{}://{address} can't be listened at: {error}", transport.name()),
            )
        };
        if transport == Transport::Udp {
            let socket = UdpSocket::bind(address).map_err(explain)?;
            return Ok(Self { transport, address: socket.local_addr()?, socket: Socket::Datagram(socket) });
        }
        let listener = TcpListener::bind(address).map_err(explain)?;
        // Whoever waits for clients has to see as well when the server ends.
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

/// Takes connections, and lets each have its thread.
fn accept(
    shared: &Arc<Shared>,
    listener: &TcpListener,
    serve_connection: fn(&Arc<Shared>, TcpStream) -> io::Result<()>,
) {
    while !shared.is_ending() {
        let stream = match listener.accept() {
            Ok((stream, _)) => stream,
            Err(error) => {
                // A client that gave up before it was taken is no reason to end, nor is a lack of descriptors.
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
            let _leaving = ConnectionGuard(&shared);
            // On some systems a connection takes after its listener.
            if stream.set_nonblocking(false).is_ok() {
                // A connection that breaks is the client's affair.
                let _ = serve_connection(&shared, stream);
            }
        });
    }
}

/// Counts a connection out, however its thread ends.
struct ConnectionGuard<'s>(&'s Shared);

impl Drop for ConnectionGuard<'_> {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}
