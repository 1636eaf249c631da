//! A reference Flockwave server with a simulated fleet, over TCP, UDP, HTTP and Socket.IO. `listen` reads requests from
//! sockets, `hub` passes each request to the file of its `family`, and the answer returns through an outbox per client.
//!
//! ```text
//!  listen ──bytes──▶ hub ──request──▶ family ──▶ world, uav, operation
//!     ▲               │ ▲                │
//!     └──outbox◀─bug──┘ └────answer──────┘
//! ```
//!
//! The server follows the specification, so client authors can test against it. The server is also used to test
//! uavspec: checks must have findings if it runs with a bug that violates a rule, and no findings otherwise.
//!
//! The hub uses neither sockets nor the system time, so the same calls always produce the same messages.
//!
//! ```
//! use std::io::{BufRead, BufReader, Write};
//! use std::net::TcpStream;
//!
//! use uavspec_serve::{Options, Server, Transport};
//!
//! let address = "127.0.0.1:0".parse().unwrap();
//! let server = Server::start(Options::default(), &[(Transport::Tcp, address)])?;
//! let mut stream = TcpStream::connect(server.listening()[0].address)?;
//! stream.write_all(b"{\"$fw.version\": \"1.0\", \"id\": \"42\", \"body\": {\"type\": \"SYS-PING\"}}\n")?;
//! // Notifications may precede the response.
//! let lines = BufReader::new(stream).lines().map_while(Result::ok);
//! let answer = lines.into_iter().find(|line| line.contains(r#""refs":"42""#)).unwrap();
//! assert!(answer.contains("ACK-ACK"));
//! # Ok::<(), std::io::Error>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

#[doc(hidden)]
pub mod driver;
mod error_code;
mod family;
mod hub;
mod listen;
mod memory;
mod message;
mod operation;
mod random;
mod request;
mod show;
mod skybrush;
#[cfg(test)]
mod tests;
mod uav;
mod world;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use std::{fmt, io};

use uavspec_model::clock::Clock;
use uavspec_rules::flockwave::FlockwaveRule;

use self::hub::{Hub, RequestHandler};
use self::listen::{Reactor, Sockets};
pub use self::memory::InMemory;

/// The transports, named as in the protocol's reference server.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Transport {
    /// One message per line.
    Tcp,
    /// One message per datagram.
    Udp,
    /// One message per request.
    Http,
    /// One message per event.
    SocketIo,
}

impl Transport {
    /// The name, which is also the URL scheme.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tcp => "tcp",
            Self::Udp => "udp",
            Self::Http => "http",
            Self::SocketIo => "socketio",
        }
    }
}

/// A transport and the address on which a server listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listening {
    /// The transport.
    pub transport: Transport,
    /// The address, with the actual port if port 0 was requested.
    pub address: SocketAddr,
}

impl fmt::Display for Listening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", self.transport.name(), self.address)
    }
}

/// Server options.
#[derive(Clone, Debug)]
pub struct Options {
    /// The number of UAVs in the fleet. The UAVs are named `glider-1`, `glider-2` and so on.
    pub uavs: usize,
    /// The seed for small variations in the simulation.
    pub seed: u64,
    /// The simulation speed. `2` means twice real time.
    pub speed: f64,
    /// The number of fleet notifications per second.
    pub rate: f64,
    /// The initial charge of all batteries, in percent.
    pub charge: f64,
    /// Initial error codes of UAVs (see [`error`]).
    pub errors: Vec<(String, u16)>,
    /// UAVs that get lost, each with the time of its loss, measured from the first connection (see [`loss`]).
    pub losses: Vec<(String, Duration)>,
    /// UAVs that appear late, each with the time of its appearance, measured from the first connection (see [`loss`]).
    pub appearances: Vec<(String, Duration)>,
    /// The commands whose results are null instead of true.
    pub null_results: Vec<String>,
    /// The maximum duration of a connection, after which the server sends SYS-CLOSE and disconnects.
    pub stay: Option<Duration>,
    /// The name and password with which clients must log in.
    pub login: Option<(String, String)>,
    /// True if the server answers as the client Skybrush Live expects, where this differs from the specification.
    pub is_for_skybrush: bool,
    /// The rule that the server violates.
    pub bug: Option<&'static FlockwaveRule>,
    /// The initial time of the server, in milliseconds since 1970.
    pub start: u64,
    /// The clock of the server. The server only reads it, so another thread must advance simulated time.
    pub clock: Clock,
}

impl Default for Options {
    fn default() -> Self {
        let now = Clock::real().since_1970();
        Self {
            uavs: 5,
            seed: 0,
            speed: 1.0,
            rate: 2.0,
            charge: 100.0,
            errors: Vec::new(),
            losses: Vec::new(),
            appearances: Vec::new(),
            null_results: Vec::new(),
            stay: None,
            login: None,
            is_for_skybrush: false,
            bug: None,
            start: u64::try_from(now.as_millis()).unwrap_or_default(),
            clock: Clock::real(),
        }
    }
}

/// Parses a UAV and its error code, such as `glider-2=66`.
pub fn error(text: &str) -> Result<(String, u16), String> {
    let (id, code) = text.split_once('=').ok_or("expected UAV=CODE, such as glider-2=66")?;
    let code = code.parse().map_err(|_| "expected a code from 0 to 65535".to_owned())?;
    error_code::settable(code)?;
    Ok((id.to_owned(), code))
}

/// Parses a UAV and the time in seconds at which it gets lost or appears, such as `glider-2@30`.
pub fn loss(text: &str) -> Result<(String, Duration), String> {
    let (id, time) = text.split_once('@').ok_or("expected UAV@SECONDS, such as glider-2@30")?;
    let seconds = time.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    let time = Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())?;
    Ok((id.to_owned(), time))
}

/// The numbers of clients that the server refused or disconnected, by reason.
pub type Counts = BTreeMap<&'static str, u64>;

/// A running server. The server ends when it is dropped, or when [`end`](Self::end) is called.
pub struct Server {
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<Counts>>,
    listening: Vec<Listening>,
}

impl Server {
    /// Listens on these addresses, and serves all clients. Port 0 selects a free port.
    pub fn start(options: Options, addresses: &[(Transport, SocketAddr)]) -> io::Result<Self> {
        Self::start_with(options, addresses, family::answer)
    }

    /// Starts a server that answers requests with this function.
    fn start_with(
        options: Options,
        addresses: &[(Transport, SocketAddr)],
        answer: RequestHandler,
    ) -> io::Result<Self> {
        let sockets = Sockets::bind(addresses)?;
        let listening = sockets.listening.clone();
        let ports = listening.iter().rev().map(|at| (at.transport.name(), at.address.port())).collect();
        let is_ending = Arc::<AtomicBool>::default();
        let of_thread = Arc::clone(&is_ending);
        let thread = thread::spawn(move || {
            let mut hub = Hub::new(options, answer);
            hub.ports = ports;
            Reactor::new(sockets, hub).run(&of_thread)
        });
        Ok(Self { is_ending, thread: Some(thread), listening })
    }

    /// The addresses of the server, in the requested order.
    pub fn listening(&self) -> &[Listening] {
        &self.listening
    }

    /// True if the server stopped because of an internal error.
    pub fn has_failed(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Sends SYS-CLOSE to all clients, and ends the server. Returns the numbers of clients that it had refused or
    /// disconnected until then.
    pub fn end(mut self) -> Counts {
        self.join()
    }

    fn join(&mut self) -> Counts {
        self.is_ending.store(true, Ordering::Release);
        // A thread that panicked has ended as well.
        self.thread.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.join();
    }
}
