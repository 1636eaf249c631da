//! The reference server: Flockwave over TCP, UDP, HTTP and Socket.IO, with a simulated fleet behind it.
//!
//! ```text
//!  listen ──bytes──▶ hub ──request──▶ family ──▶ world, uav, operation
//!     ▲               │ ▲                │
//!     └──outbox◀─bug──┘ └────answer──────┘
//! ```
//!
//! It keeps to the specification, so that authors of clients have something to try them against, and so that this
//! program can be tried on it: without a bug nothing is to be found, and with the bug of a rule that rule.
//!
//! The hub knows neither sockets nor the time of day: the same calls give the same messages.
//!
//! ```
//! use std::io::{BufRead, BufReader, Write};
//! use std::net::TcpStream;
//!
//! use uavspec_conformance::serve::{Options, Server, Transport};
//!
//! let address = "127.0.0.1:0".parse().unwrap();
//! let server = Server::start(Options::default(), &[(Transport::Tcp, address)])?;
//! let mut stream = TcpStream::connect(server.listening()[0].address)?;
//! stream.write_all(b"{\"$fw.version\": \"1.0\", \"id\": \"42\", \"body\": {\"type\": \"SYS-PING\"}}\n")?;
//! // Notifications may come first.
//! let lines = BufReader::new(stream).lines().map_while(Result::ok);
//! let answer = lines.into_iter().find(|line| line.contains(r#""refs":"42""#)).unwrap();
//! assert!(answer.contains("ACK-ACK"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod error_code;
mod family;
mod hub;
mod listen;
mod message;
mod operation;
mod outbox;
mod random;
#[cfg(test)]
mod rehearsal;
mod request;
mod uav;
mod world;

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use self::listen::Shared;
use crate::rules::flockwave::FlockwaveRule;

/// The transports, by the names that the protocol's reference server has for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Transport {
    /// A message a line.
    Tcp,
    /// A message a datagram.
    Udp,
    /// A message a request.
    Http,
    /// A message an event.
    SocketIo,
}

impl Transport {
    /// Its name: the scheme of its URLs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tcp => "tcp",
            Self::Udp => "udp",
            Self::Http => "http",
            Self::SocketIo => "socketio",
        }
    }
}

/// Where a server listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listening {
    /// Over which transport.
    pub transport: Transport,
    /// The address, with the port that was found where 0 was given.
    pub address: SocketAddr,
}

impl fmt::Display for Listening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", self.transport.name(), self.address)
    }
}

/// How a server is to be.
#[derive(Clone, Debug)]
pub struct Options {
    /// How many UAVs the fleet has: `glider-1` and so on.
    pub uavs: usize,
    /// What the small variations of the simulation depend on.
    pub seed: u64,
    /// How many seconds of the simulation a second has.
    pub speed: f64,
    /// How often clients are told of the fleet, a second.
    pub rate: f64,
    /// The charge of all batteries at the start, in percent.
    pub charge: f64,
    /// Error codes that UAVs have from the start ([`error`]).
    pub errors: Vec<(String, u16)>,
    /// UAVs that get lost, and how long after the start ([`loss`]).
    pub losses: Vec<(String, Duration)>,
    /// How long a client may stay; then the server says farewell to it.
    pub stay: Option<Duration>,
    /// Name and password without which nobody is served.
    pub login: Option<(String, String)>,
    /// The rule whose bug the server has.
    pub bug: Option<&'static FlockwaveRule>,
    /// The time of the server at the start, in milliseconds since 1970.
    pub start: u64,
}

impl Default for Options {
    fn default() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            uavs: 5,
            seed: 0,
            speed: 1.0,
            rate: 2.0,
            charge: 100.0,
            errors: Vec::new(),
            losses: Vec::new(),
            stay: None,
            login: None,
            bug: None,
            start: u64::try_from(now.as_millis()).unwrap_or_default(),
        }
    }
}

/// Reads an error code for a UAV of the fleet: `glider-2=66`.
pub fn error(text: &str) -> Result<(String, u16), String> {
    let (id, code) = text.split_once('=').ok_or("write UAV=CODE, such as glider-2=66")?;
    let code = code.parse().map_err(|_| "the code is no number from 0 to 65535".to_owned())?;
    error_code::settable(code)?;
    Ok((id.to_owned(), code))
}

/// Reads when a UAV of the fleet gets lost: `glider-2@30`, in seconds.
pub fn loss(text: &str) -> Result<(String, Duration), String> {
    let (id, time) = text.split_once('@').ok_or("write UAV@SECONDS, such as glider-2@30")?;
    let seconds = time.parse().map_err(|_| "the time is no number of seconds".to_owned())?;
    let time = Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())?;
    Ok((id.to_owned(), time))
}

/// A server that runs. It ends when it is dropped, or with [`end`](Self::end).
pub struct Server {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    listening: Vec<Listening>,
}

impl Server {
    /// Listens at these addresses, and serves whoever connects. Port 0 finds a free one.
    pub fn start(options: Options, addresses: &[(Transport, SocketAddr)]) -> io::Result<Self> {
        let mut bound = Vec::new();
        for (transport, address) in addresses {
            bound.push(listen::Bound::bind(*transport, *address)?);
        }
        let listening: Vec<Listening> = bound.iter().map(listen::Bound::listening).collect();
        let shared = Arc::new(Shared::new(options, &listening));
        let mut threads = vec![listen::keep_time(&shared)];
        threads.extend(bound.into_iter().map(|bound| bound.serve(&shared)));
        Ok(Self { shared, threads, listening })
    }

    /// Where it listens, in the order that was asked for.
    pub fn listening(&self) -> &[Listening] {
        &self.listening
    }

    /// Says farewell to all clients, and ends.
    pub fn end(self) {
        drop(self);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.end();
        for thread in self.threads.drain(..) {
            // A thread that panicked has ended, too.
            let _ = thread.join();
        }
        self.shared.wait_for_connections();
    }
}
