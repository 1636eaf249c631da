//! Reads captures (logs, MCAP and JSON) as streams, in bounded memory.

pub(crate) mod foreign;
pub(crate) mod input;
pub(crate) mod json;
pub(crate) mod mcap;
pub(crate) mod names;
pub(crate) mod rosbag;
#[cfg(feature = "stores")]
pub(crate) mod store;
pub mod ulog;

/// The first bytes of MCAP files.
pub(crate) use self::mcap::MAGIC as MCAP_MAGIC;

/// The first bytes of encrypted PX4 logs.
pub(crate) const ENCRYPTED_MAGIC: [u8; 7] = *b"ULogEnc";

/// The first bytes of PX4 logs.
pub(crate) const ULOG_MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";
