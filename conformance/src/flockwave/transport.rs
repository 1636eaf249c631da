//! Live connections: what Flockwave travels over, both ends.
//!
//! | transport | a message is | client | server |
//! |---|---|---|---|
//! | TCP | a line | [`client`] | `serve` |
//! | UDP | a datagram | [`client`] | `serve` |
//! | HTTP | the body of a POST, or of its answer | [`client`] | [`http`] |
//! | Socket.IO | the argument of an event `fw` | [`client`] | [`engine`], [`socketio`] |
//!
//! Nothing here waits without a time limit, and nothing keeps more than [`MESSAGE_LIMIT`] of what comes in.

pub mod client;
pub mod endpoint;
pub mod engine;
pub mod http;
pub mod lines;
pub mod socketio;

/// The longest message that is taken, in bytes. The specification has no limit; what is longer than this was hardly
/// meant as a message, and has to be kept whole to be read.
pub const MESSAGE_LIMIT: usize = 16 << 20;

/// Where the messages of HTTP one-shots go: the path that the reference server of the protocol has. The
/// specification doesn't know this transport.
pub const ONE_SHOT_PATH: &str = "/api/v1";

/// Where Socket.IO is served: the path that its clients take where nothing else is said.
pub const SOCKET_IO_PATH: &str = "/socket.io/";
