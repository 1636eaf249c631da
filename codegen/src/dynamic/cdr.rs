//! CDR by the steps of a plan.
//!
//! Reading and writing only say that something is wrong; what it is and where, [`explain`] and
//! [`refuse`](write::refuse) find out in a second pass, so that the first needs to keep no account of
//! where it is.

mod explain;
mod read;
mod write;

pub(super) use read::decode;
pub(super) use write::encode;
