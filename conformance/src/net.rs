//! TCP connections with time limits, with or without TLS.

mod address;
mod connection;
mod stream;
mod timed;
pub(crate) mod tls;

pub(crate) use self::address::Address;
pub(crate) use self::connection::{Connection, explain, resolve};
pub(crate) use self::stream::Stream;
pub(crate) use self::timed::is_silence;
