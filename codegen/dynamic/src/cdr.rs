//! CDR codec.

mod read;
mod transfer;
mod write;

pub(super) use read::decode;
pub(super) use write::encode;
