//! The width limit for alignment.

/// The maximum width for alignment, in characters. A wider declaration or cell doesn't affect the alignment of others.
/// Without this limit, one long line would widen every line of its block, and the output could grow quadratically.
pub(super) const ALIGNED_WITHIN: usize = 100;
