//! Alignment.

/// Longest declaration or cell, in characters, that others are aligned with. Without a bound one line could
/// widen all lines of its block, and the text would grow with the square of its length.
pub(super) const ALIGNED_WITHIN: usize = 100;
