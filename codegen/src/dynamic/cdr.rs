//! CDR codec that executes the steps of a plan.
//!
//! Reading and writing don't track their position. If they fail, [`explain`] and [`refuse`](write::refuse) find the
//! cause and its location in a second pass.

mod explain;
mod read;
mod write;

pub(super) use read::decode;
pub(super) use write::encode;
