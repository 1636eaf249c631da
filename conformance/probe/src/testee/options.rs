//! Options of a run.

use std::time::Duration;

use uavspec_model::clock::Clock;

use super::target::Target;
use crate::limits::LINE_LIMIT;

/// Options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The testee to run.
    pub target: Target,
    /// The maximum number of pending requests per process.
    pub window: usize,
    /// The time limit for the next response.
    pub timeout: Duration,
    /// The time limit for connecting and for receiving the hello.
    pub start_timeout: Duration,
    /// The number of concurrent processes.
    pub jobs: usize,
    /// The maximum number of consecutive restarts of one job that don't lead to a case which crashes the testee by
    /// itself.
    pub max_restarts: u32,
    /// The maximum number of consecutive timeouts of one job. The run also ends if the total number of timeouts is
    /// three times as high.
    pub max_timeouts: u32,
    /// The maximum length of a line, in bytes.
    pub line_limit: usize,
    /// The clock for the time limits. The run only reads it, so another thread must advance simulated time.
    pub clock: Clock,
}

impl Options {
    /// The default options.
    pub const fn new(target: Target) -> Self {
        Self {
            target,
            window: 32,
            timeout: Duration::from_secs(5),
            // Some virtual machines start slowly.
            start_timeout: Duration::from_secs(30),
            jobs: 1,
            max_restarts: 20,
            max_timeouts: 3,
            line_limit: LINE_LIMIT,
            clock: Clock::real(),
        }
    }

    /// The maximum total length of the lines between two responses, in bytes. A testee that writes more counts as
    /// unresponsive.
    pub(super) const fn stray_limit(&self) -> usize {
        self.line_limit / 64
    }

    /// The maximum total length of the lines in a run that aren't correct responses, in bytes.
    pub(super) const fn wrong_limit(&self) -> usize {
        self.line_limit.saturating_mul(8)
    }
}

/// The beginning of a line, as quoted text.
pub(super) fn excerpt(line: &[u8]) -> String {
    const MAX_LENGTH: usize = 80;
    let part = line.get(..MAX_LENGTH).unwrap_or(line);
    let end = if line.len() > MAX_LENGTH { "…" } else { "" };
    format!("`{}{end}`", String::from_utf8_lossy(part).trim_end())
}
