//! TCP connections with time limits, with or without TLS, and the limit of open files.

mod address;
mod connection;
mod files;
mod stream;
mod timed;
pub mod tls;

pub use self::address::Address;
pub use self::connection::{Connection, explain, resolve};
pub use self::files::{open_files, raise_open_files};
pub use self::stream::Stream;
pub use self::timed::is_silence;
