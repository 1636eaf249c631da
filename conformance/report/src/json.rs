//! Renders reports as JSON.
//!
//! The schema is `generated/schemas/uavspec/report.schema.json`, which is generated from the same types.

use std::io::{self, Write};

use uavspec_schema::json_text;

use super::format::{Format, Run};
use super::spool::Spool;
use super::{Report, Subject};

/// The list of subjects, in a report without subjects. Texts contain no line breaks, and the lines of inner objects are
/// indented further, so no other line is like it.
const NO_SUBJECTS: &str = "\n  \"subjects\": [],\n";

/// The indentation of a subject.
const INDENT: &str = "    ";

/// A JSON report under construction.
#[derive(Debug)]
pub(super) struct Json {
    subjects: Spool,
    is_empty: bool,
}

impl Json {
    pub(super) fn new(subjects: Spool) -> Self {
        Self { subjects, is_empty: true }
    }
}

impl Format for Json {
    fn add(&mut self, subject: &Subject, _: Run<'_>) -> io::Result<()> {
        let mut separator = if self.is_empty { "" } else { ",\n" };
        self.is_empty = false;
        for line in json_text::pretty(subject).lines() {
            write!(self.subjects, "{separator}{INDENT}{line}")?;
            separator = "\n";
        }
        Ok(())
    }

    fn finish(self: Box<Self>, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        let text = json_text::pretty(report);
        let Some((before, after)) = text.split_once(NO_SUBJECTS).filter(|_| !self.is_empty) else {
            return to.write_all(text.as_bytes());
        };
        write!(to, "{before}\n  \"subjects\": [\n")?;
        self.subjects.copy_to(to)?;
        write!(to, "\n  ],\n{after}")
    }
}

/// Renders a report that has its subjects.
pub(super) fn write(report: &Report) -> String {
    json_text::pretty(report)
}
