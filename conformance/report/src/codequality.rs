//! Renders reports in the Code Quality format of GitLab.

use std::io::{self, Read as _, Write};

use uavspec_lint::report::Entry;
use uavspec_lint::report::codequality::{Issues, write_list};

use super::entries::{of_run, of_subject};
use super::kind::{Format, Parts};
use super::{Report, Subject};

/// A report under construction.
#[derive(Debug, Default)]
pub(super) struct CodeQuality(Issues);

impl CodeQuality {
    /// The issues as lines of JSON.
    fn lines(&mut self, entries: &[Entry]) -> String {
        entries.iter().map(|entry| self.0.line(entry)).collect()
    }
}

impl Format for CodeQuality {
    fn add(&mut self, subject: &Subject) -> String {
        self.lines(&of_subject(subject))
    }

    fn finish(mut self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        write_list(parts.chain(self.lines(&of_run(report)).as_bytes()), to)
    }
}
