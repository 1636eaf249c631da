//! Renders reports as JSON.
//!
//! The schema is `generated/schemas/uavspec/report.schema.json`, which is generated from the same types.

use std::io::{self, Write};

use uavspec_schema::json_text;

use super::kind::{Format, Parts};
use super::{Report, Subject};

/// The line that contains the list of subjects in a report without subjects. Texts contain no line breaks, and the
/// lines of inner objects are indented more, so this line is unique.
const NO_SUBJECTS: &str = "\n  \"subjects\": [],\n";

/// A JSON report under construction.
pub(super) struct Json;

impl Format for Json {
    fn add(&mut self, subject: &Subject) -> String {
        let text = json_text::pretty(subject);
        format!(",\n    {}", text.trim_end().replace('\n', "\n    "))
    }

    fn finish(self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        let text = json_text::pretty(report);
        let has_parts = !parts.fill_buf()?.is_empty();
        let Some((before, after)) = text.split_once(NO_SUBJECTS).filter(|_| has_parts) else {
            return to.write_all(text.as_bytes());
        };
        write!(to, "{before}\n  \"subjects\": [")?;
        // Nothing precedes the first comma.
        parts.consume(1);
        io::copy(parts, to)?;
        write!(to, "\n  ],\n{after}")
    }
}
