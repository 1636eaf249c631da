//! Workflow commands of GitHub, which shows them beside the lines of a change.
//!
//! The form: <https://docs.github.com/actions/reference/workflow-commands-for-github-actions>.

use std::fmt::Write as _;

use super::Report;
use crate::diagnostic::Level;

pub(super) fn write(report: &Report) -> String {
    let mut text = String::new();
    for entry in &report.entries {
        let command = match entry.level {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "notice",
        };
        let (start, end) = (entry.place.start, entry.place.end);
        // Columns mean something only within one line.
        let columns = if start.line == end.line {
            format!(",col={},endColumn={}", start.column, end.column)
        } else {
            String::new()
        };
        let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
        let message = format!("{}\n{}\n{}", entry.message, entry.help, entry.url());
        let _ = writeln!(
            text,
            "::{command} file={},line={},endLine={}{columns},title={}::{}",
            property(&entry.place.path),
            start.line,
            end.line,
            property(&format!("{}{category}", entry.rule)),
            data(&message),
        );
    }
    text
}

/// Escapes what would end the message.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes what would end a property.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
