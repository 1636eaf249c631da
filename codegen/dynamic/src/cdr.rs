//! CDR codec that executes the steps of a plan.
//!
//! The codec doesn't track the path of the current value. If reading or writing fails, [`explain`] and
//! [`refuse`](write::refuse) find the cause and its location in a second pass.

mod explain;
mod read;
mod write;

pub(super) use read::decode;
pub(super) use write::encode;
