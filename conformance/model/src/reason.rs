//! Failures of a whole run.

use std::fmt;

use serde::Serialize;

/// The reason why a whole run fails.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Reason {
    /// A description of the failure.
    pub message: String,
    /// The path of the baseline that made the run fail; empty if no baseline did.
    pub path: String,
    /// The line in the list.
    pub line: Option<u64>,
}

impl From<String> for Reason {
    fn from(message: String) -> Self {
        Self { message, path: String::new(), line: None }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { message, path, line } = self;
        match line {
            Some(line) => write!(formatter, "{path}:{line}: {message}"),
            None => formatter.write_str(message),
        }
    }
}
