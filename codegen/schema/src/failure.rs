//! Failures of commands.

use std::fmt;

use crate::terminal::guarded;

/// The reason why a command failed, with a hint.
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
}

impl std::error::Error for Failure {}

impl Failure {
    /// Creates a failure without a hint.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    /// Adds a hint about what to do.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A message may have several lines, but none of them may contain other control characters.
        write!(formatter, "error: {}", guarded(&self.message))?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(formatter, "\n  help: {}", guarded(hint)))
    }
}
