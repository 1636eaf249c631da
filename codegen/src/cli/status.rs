//! The exit status of commands.

/// The result of a command that could run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    Success = 0,
    /// There are findings, or outdated files.
    Failed = 1,
    /// A baseline is out of date.
    Outdated = 4,
}

impl Status {
    /// The status of a command that succeeded or failed. A failure takes precedence over an outdated baseline.
    pub(super) fn new(succeeded: bool, is_outdated: bool) -> Self {
        match (succeeded, is_outdated) {
            (false, _) => Self::Failed,
            (true, true) => Self::Outdated,
            (true, false) => Self::Success,
        }
    }
}

impl From<bool> for Status {
    fn from(succeeded: bool) -> Self {
        Self::new(succeeded, false)
    }
}
