//! Syntax errors.

use std::fmt;

/// The error for a text that isn't JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// The offset of the byte.
    pub at: usize,
    /// The problem at that byte.
    pub problem: &'static str,
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "invalid JSON: {} at byte {}", self.problem, self.at)
    }
}

impl std::error::Error for SyntaxError {}
