//! Codec for the JSON form that the published schemas describe.

mod number;
mod read;
mod write;

pub(super) use read::{Builder, MessageSeed};
pub(super) use write::explain;
