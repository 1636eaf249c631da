//! CDR codec.

mod read;
mod write;

pub(super) use read::decode;
pub(super) use write::encode;
