//! The JSON that the published schemas describe.

mod number;
mod read;
mod write;

pub(super) use read::{Builder, MessageSeed};
pub(super) use write::unsayable;
