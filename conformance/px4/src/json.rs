//! Checks JSON messages against their definitions.
//!
//! Most text takes a fast path: one pass without a tree, which can only confirm that a message has no findings
//! ([`Plans::read`]).
//!
//! Everything else is parsed into a [`Tree`](uavspec_model::json::Tree). A tree preserves repeated keys, the text of numbers, and non-JSON tokens
//! such as `NaN`. All findings come from the tree ([`Plans::explain`]). The fast path and the tree use the same checks
//! of single values (`value.rs`). A test with randomly changed messages compares the results of the fast path with the
//! results of the tree.

mod clean;
pub mod decode;
mod dialect;
mod differences;
mod explain;
mod value;

pub use self::clean::Clean;
pub use self::decode::decode;
pub use self::dialect::{Dialect, Dialects};
pub use self::differences::count_differences;
pub use self::explain::MessageOrigin;
pub use self::value::is_byte;
pub use super::values::{Plans, SharedFields};
