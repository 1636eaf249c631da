//! What is judged: logs and captures, read as they come, in bounded memory.

pub mod json;
pub mod ulog;

/// What a log of PX4 begins with; everything else is taken for JSON.
pub(crate) const ULOG_MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";
