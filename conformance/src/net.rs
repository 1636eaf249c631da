//! Connections over TCP, with time limits.

mod address;
mod connection;

pub use self::address::Address;
pub(crate) use self::connection::{Connection, resolve};
