//! Options of a run, and the lines that it reads.

use std::time::Duration;

use super::target::Target;

/// The longest line that is read, in bytes, unless something else is said.
pub(crate) const LINE_LIMIT: usize = 16 << 20;

/// How a testee is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where it is found.
    pub target: Target,
    /// How many questions are on their way to a process at once.
    pub window: usize,
    /// How long a process may be silent while there are questions.
    pub timeout: Duration,
    /// How long it may take to introduce itself, and to take a connection.
    pub start_timeout: Duration,
    /// How many processes run at once.
    pub jobs: usize,
    /// How often processes are started again in a row without a case being found that brings them down alone.
    pub max_restarts: u32,
    /// The longest line that is read, in bytes.
    pub line_limit: usize,
}

impl Options {
    /// The usual ones.
    pub const fn new(target: Target) -> Self {
        Self {
            target,
            window: 32,
            timeout: Duration::from_secs(5),
            // Some virtual machines take their time.
            start_timeout: Duration::from_secs(30),
            jobs: 1,
            max_restarts: 20,
            line_limit: LINE_LIMIT,
        }
    }
}

/// The beginning of a line, as text.
pub(super) fn excerpt(line: &[u8]) -> String {
    const MAX_LENGTH: usize = 80;
    let part = line.get(..MAX_LENGTH).unwrap_or(line);
    let end = if line.len() > MAX_LENGTH { "…" } else { "" };
    format!("`{}{end}`", String::from_utf8_lossy(part).trim_end())
}
