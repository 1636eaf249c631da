//! Renders reports as JSON.
//!
//! The schema is `generated/schemas/uavspec/report.schema.json`, which is generated from the same types.

use std::io::{self, Write};

use uavspec_codegen::json_text;

use super::format::{Format, Run};
use super::spool::Spool;
use super::{Report, Subject};

/// The line of the list of subjects, in a report without subjects. Texts contain no line breaks, and the lines of inner
/// objects are indented further, so no other line is like it.
const NO_SUBJECTS: &[u8] = b"  \"subjects\": [],\n";

/// The indentation of a subject.
const INDENT: &[u8] = b"    ";

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
        self.subjects.write_all(if self.is_empty { INDENT } else { b",\n    " })?;
        self.is_empty = false;
        json_text::write_pretty(subject, Indented(&mut self.subjects))
    }

    fn finish(self: Box<Self>, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        let subjects = (!self.is_empty).then_some(self.subjects);
        let mut splice = Splice { to, line: Vec::new(), subjects };
        json_text::write_pretty(report, &mut splice)?;
        splice.write_all(b"\n")
    }
}

/// Renders a report that has its subjects.
pub(super) fn write(report: &Report) -> String {
    json_text::pretty(report)
}

/// Indents each line except for the first.
struct Indented<'w>(&'w mut Spool);

impl Write for Indented<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.0.write_all(part)?;
            if part.ends_with(b"\n") {
                self.0.write_all(INDENT)?;
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Copies a report, and inserts the subjects.
struct Splice<'w> {
    to: &'w mut dyn Write,
    /// The current line.
    line: Vec<u8>,
    subjects: Option<Spool>,
}

impl Splice<'_> {
    fn end_line(&mut self) -> io::Result<()> {
        if self.line == NO_SUBJECTS
            && let Some(subjects) = self.subjects.take()
        {
            self.to.write_all(b"  \"subjects\": [\n")?;
            subjects.copy_to(self.to)?;
            self.to.write_all(b"\n  ],\n")?;
        } else {
            self.to.write_all(&self.line)?;
        }
        self.line.clear();
        Ok(())
    }
}

impl Write for Splice<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.line.extend_from_slice(part);
            if part.ends_with(b"\n") {
                self.end_line()?;
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}
