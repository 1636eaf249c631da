//! Error codes of a package.

use std::ops::RangeInclusive;

use uavspec_runtime::{ErrorClass, Severity};

use crate::source::Span;

/// A table of error codes.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// Its heading without the range.
    pub title: String,
    /// The class of all its codes.
    pub class: ErrorClass,
    /// The codes that the heading sets apart for it.
    pub range: RangeInclusive<u32>,
    /// The codes that it defines, sorted.
    pub codes: Vec<ErrorCode>,
    /// The heading.
    pub span: Span,
}

/// An error code.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCode {
    /// The code.
    pub code: u32,
    /// What user interfaces show where space is short.
    pub abbreviation: Option<String>,
    /// The class of its table.
    pub class: ErrorClass,
    /// Codes that its description refers to, sorted.
    pub see_also: Vec<u32>,
    /// Codes of which only one stands for the same event: `use … only if …; otherwise use code N`.
    /// Sorted; each of them has this code among its own.
    pub alternatives: Vec<u32>,
    /// What it means.
    pub description: String,
    /// The version of the specification that introduced it.
    pub since: Option<String>,
    /// The cell that gives the code.
    pub span: Span,
}

impl ErrorCode {
    /// How grave it is, by the two bits of the code that say so.
    pub fn severity(&self) -> Severity {
        Severity::of(self.code)
    }
}
