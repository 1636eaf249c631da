//! TCP connections with time limits.

mod address;
mod connection;

pub(crate) use self::address::Address;
pub(crate) use self::connection::{Connection, resolve};
