//! Failures of a run as a whole.

use std::fmt;

use serde::Serialize;

/// Why a run as a whole fails.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Reason {
    /// What is the matter.
    pub message: String,
    /// The list that it is about; empty where it is about none.
    pub path: String,
    /// The line in it.
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
