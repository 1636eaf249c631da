//! The width limit for alignment.

/// The maximum width, in characters, of a declaration or cell that affects the alignment of others. Without this limit,
/// one long line would widen every line of its block, and the output could grow quadratically.
pub(super) const ALIGNED_WITHIN: usize = 100;
