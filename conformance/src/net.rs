//! TCP connections with time limits, with or without TLS, and the limit of open files.

mod address;
mod connection;
mod files;
mod stream;
mod timed;
pub(crate) mod tls;

pub(crate) use self::address::Address;
pub(crate) use self::connection::{Connection, explain, resolve};
pub(crate) use self::files::open_files;
#[cfg(feature = "dds")]
pub(crate) use self::files::raise_open_files;
pub(crate) use self::stream::Stream;
pub(crate) use self::timed::is_silence;
