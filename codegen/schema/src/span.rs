//! Byte ranges in the sources of a run.

use std::ops::Range;

/// A byte range in a source of a [`SourceMap`](crate::SourceMap).
///
/// A span has only eight bytes, because positions are counted across all sources of the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The position of the first byte.
    pub start: u32,
    /// The position after the last byte.
    pub end: u32,
}

impl Span {
    /// The span from the start of `self` to the end of `other`.
    #[must_use]
    pub fn to(self, other: Self) -> Self {
        Self { start: self.start, end: other.end }
    }

    /// The part of this span in `range`, which is relative to the start of the span.
    #[must_use]
    pub fn part(self, range: Range<usize>) -> Self {
        Self { start: self.start + offset(range.start), end: self.start + offset(range.end) }
    }
}

/// Converts a position. The conversion is lossless for valid sources. For an oversized source, only the displayed
/// location is wrong.
pub fn offset(position: usize) -> u32 {
    u32::try_from(position).unwrap_or(u32::MAX)
}
