//! Reads captures as streams, in bounded memory: bytes in, records out. The formats are `ULog`, MCAP, rosbag2's
//! `SQLite` and JSON, also compressed, from files and standard input. `uavspec-stores` reads object stores. The
//! documentation of [`ulog`] has an example.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod foreign;
pub mod input;
pub mod json;
pub mod limits;
pub mod mcap;
pub mod names;
pub mod rosbag;
pub mod ulog;
mod window;

/// The first bytes of MCAP files.
pub use self::mcap::MAGIC as MCAP_MAGIC;

/// The first bytes of encrypted PX4 logs.
pub const ENCRYPTED_MAGIC: [u8; 7] = *b"ULogEnc";

/// The first bytes of PX4 logs.
pub const ULOG_MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";
