//! What is judged: logs and captures, read as they come, in bounded memory.

pub(crate) mod input;
pub(crate) mod json;
pub(crate) mod mcap;
pub mod ulog;

/// What MCAP begins with.
pub(crate) use self::mcap::MAGIC as MCAP_MAGIC;

/// What a log of PX4 begins with that is encrypted.
pub(crate) const ENCRYPTED_MAGIC: [u8; 7] = *b"ULogEnc";

/// What a log of PX4 begins with; what begins neither so nor as MCAP is taken for JSON.
pub(crate) const ULOG_MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";
