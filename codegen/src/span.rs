//! Ranges of bytes in the sources of a run.

use std::ops::Range;

/// A range of bytes in one of the sources of a [`SourceMap`](crate::SourceMap).
///
/// Eight bytes: positions count through all sources of the map, one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// Position of the first byte.
    pub start: u32,
    /// Position after the last byte.
    pub end: u32,
}

impl Span {
    /// The span from the start of `self` to the end of `other`.
    #[must_use]
    pub fn to(self, other: Self) -> Self {
        Self { start: self.start, end: other.end }
    }

    /// The part of this span that `range`, counted from its start, names.
    #[must_use]
    pub fn part(self, range: Range<usize>) -> Self {
        Self { start: self.start + offset(range.start), end: self.start + offset(range.end) }
    }
}

/// A position as spans hold it. Lossless for sources of the length that is read; else it only moves a caret.
pub(crate) fn offset(position: usize) -> u32 {
    u32::try_from(position).unwrap_or(u32::MAX)
}
