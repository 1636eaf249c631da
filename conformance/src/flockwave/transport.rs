//! Live connections: what Flockwave travels over, both ends.
//!
//! | transport | a message is | client | server |
//! |---|---|---|---|
//! | TCP | a line | `client` | `serve` |
//! | UDP | a datagram | `client` | `serve` |
//! | HTTP | the body of a POST, or of its answer | `client` | `http` |
//! | Socket.IO | the argument of an event `fw` | `client` | `engine`, `socketio` |
//!
//! Nothing here waits without a time limit, and nothing keeps more than [`MESSAGE_LIMIT`] of what comes in.
//!
//! ```
//! use std::time::{Duration, Instant};
//!
//! use uavspec_conformance::serve::{Options, Server, Transport};
//! use uavspec_conformance::transport::{Endpoint, Received, connect};
//!
//! let server = Server::start(Options::default(), &[(Transport::SocketIo, "127.0.0.1:0".parse().unwrap())])?;
//! let endpoint: Endpoint = server.listening()[0].to_string().parse().unwrap();
//! let until = Instant::now() + Duration::from_secs(60);
//! let mut client = connect(&endpoint, until)?;
//! client.send(br#"{"$fw.version": "1.0", "id": "42", "body": {"type": "SYS-VER"}}"#)?;
//! assert!(matches!(client.receive(until)?, Received::Message(_)));
//! # Ok::<(), std::io::Error>(())
//! ```

pub(crate) mod client;
pub(crate) mod endpoint;
pub(crate) mod engine;
pub(crate) mod http;
pub(crate) mod lines;
pub(crate) mod socketio;

pub use self::client::{Client, Received, connect};
pub use self::endpoint::{Carrier, Endpoint};
pub use self::engine::Revision;

/// The longest message that is taken, in bytes. The specification has no limit; what is longer than this was hardly
/// meant as a message, and has to be kept whole to be read.
pub const MESSAGE_LIMIT: usize = 16 << 20;

/// Where the messages of HTTP one-shots go: the path that the reference server of the protocol has. The
/// specification doesn't know this transport.
pub(crate) const ONE_SHOT_PATH: &str = "/api/v1";

/// Where Socket.IO is served: the path that its clients take where nothing else is said.
pub(crate) const SOCKET_IO_PATH: &str = "/socket.io/";
