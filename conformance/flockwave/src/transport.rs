//! Live connections over the Flockwave transports, on both the client and the server side.
//!
//! | transport | a message is | client | server |
//! |---|---|---|---|
//! | TCP | a line | `client` | `serve` |
//! | UDP | a datagram | `client` | `serve` |
//! | HTTP | the body of a POST request or its response | `client` | `http` |
//! | Socket.IO | the argument of an `fw` event | `client` | `engine`, `socketio` |
//!
//! With the feature `tls`, clients also connect over TLS, except for UDP. [`Access`] holds the login and the trusted
//! certificates. Clients follow redirects on the same host.
//!
//! All waits have a time limit, and no more than [`MESSAGE_LIMIT`] bytes of received data are stored.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use uavspec_model::clock::Clock;
//! use uavspec_flockwave::transport::{Endpoint, Received, connect};
//!
//! let endpoint: Endpoint = "socketio://127.0.0.1:5000".parse().unwrap();
//! let until = Clock::real().now() + Duration::from_secs(60);
//! let mut client = connect(&endpoint, until)?;
//! client.send(br#"{"$fw.version": "1.0", "id": "42", "body": {"type": "SYS-VER"}}"#)?;
//! assert!(matches!(client.receive(until)?, Received::Message(_)));
//! # Ok::<(), std::io::Error>(())
//! ```

pub mod access;
pub mod client;
pub mod endpoint;
pub mod engine;
pub mod http;
pub mod lines;
pub mod secrets;
pub mod socketio;

pub use uavspec_model::net::tls::Trust;

pub use self::access::Access;
pub use self::client::{Client, Network, Received, connect, connect_with, http_status, is_temporary};
pub use self::endpoint::{Carrier, Endpoint, ServerAddress};
pub use self::engine::Revision;

/// The maximum size of a message, in bytes. The specification has no limit, but messages must be read into memory.
pub const MESSAGE_LIMIT: usize = 16 << 20;

/// The path for stateless HTTP, as in the reference server of the protocol. The specification doesn't describe this
/// transport.
pub const ONE_SHOT_PATH: &str = "/api/v1";

/// The default path of Socket.IO.
pub const SOCKET_IO_PATH: &str = "/socket.io/";
