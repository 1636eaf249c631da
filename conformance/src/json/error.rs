//! Syntax errors.

use std::fmt;

/// The error of a text that is not JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// The offset of the byte.
    pub at: usize,
    /// The problem at that byte.
    pub problem: &'static str,
}

impl fmt::Display for SyntaxError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "no JSON: {} at byte {}", self.problem, self.at)
    }
}

impl std::error::Error for SyntaxError {}
