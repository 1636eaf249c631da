//! A report under construction.

use std::io::{self, Write};

use super::{Action, Report, Subject};

/// The facts about a run that are known when a subject is added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<'r> {
    /// The command that was run.
    pub(super) action: Action,
    /// The command line that reproduces the report.
    pub(super) command: &'r str,
    /// True if the run has only one subject.
    pub(super) is_single: bool,
}

/// A report in one format, under construction.
pub(super) trait Format {
    /// Adds a subject.
    fn add(&mut self, subject: &Subject, run: Run<'_>) -> io::Result<()>;

    /// Writes the whole report. `report` may have no subjects; its totals include all added subjects.
    fn finish(self: Box<Self>, report: &Report, to: &mut dyn Write) -> io::Result<()>;
}
