//! Error codes of a package.

use std::ops::RangeInclusive;

use uavspec_runtime::{ErrorClass, Severity};

use crate::source::Span;

/// A table of error codes.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// The heading without the range.
    pub title: String,
    /// The class of all codes in the table.
    pub class: ErrorClass,
    /// The codes that the heading reserves.
    pub range: RangeInclusive<u32>,
    /// The defined codes, sorted.
    pub codes: Vec<ErrorCode>,
    /// The heading.
    pub span: Span,
}

/// An error code.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCode {
    /// The code.
    pub code: u32,
    /// The short text for user interfaces.
    pub abbreviation: Option<String>,
    /// The class of the table.
    pub class: ErrorClass,
    /// The codes that the description refers to, sorted.
    pub see_also: Vec<u32>,
    /// Alternative codes for the same event: `use … only if …; otherwise use code N`. The list is sorted and symmetric:
    /// if code A lists code B, then code B also lists code A.
    pub alternatives: Vec<u32>,
    /// The description.
    pub description: String,
    /// The specification version that introduced the code.
    pub since: Option<String>,
    /// The cell with the code.
    pub span: Span,
}

impl ErrorCode {
    /// The severity, encoded in two bits of the code.
    pub fn severity(&self) -> Severity {
        Severity::of(self.code)
    }
}
