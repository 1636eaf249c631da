//! JSON codec, for the JSON described by the published schemas.

mod number;
mod read;
mod write;

pub(super) use read::{Builder, MessageSeed};
pub(super) use write::explain;
