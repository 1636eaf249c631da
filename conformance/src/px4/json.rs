//! Checks JSON messages against their definitions.
//!
//! If a message differs from an earlier message only in its values, a comparison with the earlier message suffices
//! (`template.rs`). Other text takes a fast path: one pass without a tree, which can only confirm that a message has no
//! findings ([`Plans::read`]).
//!
//! Everything else is parsed into a [`Tree`]. A tree preserves repeated keys, the text of numbers, and non-JSON tokens
//! such as `NaN`. All findings come from the tree ([`Plans::explain`]). The fast path and the tree use the same checks
//! of single values (`value.rs`). A test with randomly changed messages compares the results of the fast path with
//! those of the tree.

mod clean;
mod decode;
mod dialect;
mod differences;
mod explain;
mod template;
#[cfg(test)]
mod tests;
mod value;

pub(crate) use self::clean::Clean;
pub(crate) use self::decode::{decode, is_bytes};
pub(crate) use self::dialect::{Dialect, Dialects};
pub(crate) use self::differences::count_differences;
pub(crate) use self::explain::MessageOrigin;
pub(crate) use self::template::Template;
pub(crate) use super::values::{Plans, SharedFields};
