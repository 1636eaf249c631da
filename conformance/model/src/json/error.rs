//! Syntax errors.

use std::fmt;

/// The error for text that isn't JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// The byte offset of the error.
    pub at: usize,
    /// The problem at this offset.
    pub problem: &'static str,
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "invalid JSON: {} at byte {}", self.problem, self.at)
    }
}

impl std::error::Error for SyntaxError {}
