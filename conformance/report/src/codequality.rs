//! Renders reports in the Code Quality format of GitLab.

use std::io::{self, Write};

use uavspec_lint::report::Entry;
use uavspec_lint::report::codequality::{Issues, write_list};

use super::entries::{of_run, of_subject};
use super::format::{Format, Run};
use super::spool::Spool;
use super::{Report, Subject};

/// A report under construction.
#[derive(Debug)]
pub(super) struct CodeQuality {
    issues: Issues,
    /// The issues as lines of JSON.
    lines: Spool,
}

impl CodeQuality {
    pub(super) fn new(lines: Spool) -> Self {
        Self { issues: Issues::default(), lines }
    }

    fn push(&mut self, entries: &[Entry]) -> io::Result<()> {
        entries.iter().try_for_each(|entry| self.lines.write_all(self.issues.line(entry).as_bytes()))
    }
}

impl Format for CodeQuality {
    fn add(&mut self, subject: &Subject, _: Run<'_>) -> io::Result<()> {
        self.push(&of_subject(subject))
    }

    fn finish(mut self: Box<Self>, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        self.push(&of_run(report))?;
        write_list(self.lines.into_reader()?, to)
    }
}
