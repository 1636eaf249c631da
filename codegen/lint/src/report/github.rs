//! GitHub workflow commands, which add annotations to changed lines.
//!
//! Format: <https://docs.github.com/actions/reference/workflow-commands-for-github-actions>.

use std::fmt::Write as _;

use uavspec_schema::diagnostic::Level;
use uavspec_schema::terminal::guarded;

use super::model::{Region, Report};
use super::totals::Totals;

pub(super) fn write(report: &Report, totals: Option<&Totals>) -> String {
    // Print the totals first, because GitHub displays only the first annotations of a step.
    let mut text = totals.filter(|totals| totals.count() > 0).map(summary).unwrap_or_default();
    for entry in &report.entries {
        let command = match entry.level {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "notice",
        };
        let region = region(entry.place.region);
        let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
        let message = format!("{}\n{}\n{}", entry.message, entry.help, entry.url);
        let message = message.trim_end();
        let _ = writeln!(
            text,
            "::{command} file={}{region},title={}::{}",
            property(&entry.place.path),
            property(&format!("{}{category}", entry.rule)),
            data(message),
        );
    }
    text
}

/// An annotation with the totals.
pub(super) fn summary(totals: &Totals) -> String {
    format!("::notice title={}::{}\n", property(totals.command), data(totals.to_text().trim_end()))
}

/// The properties of a region; empty for the whole file or a byte offset.
fn region(region: Region) -> String {
    match region {
        Region::Whole | Region::Byte(_) => String::new(),
        Region::Line(line) => format!(",line={line}"),
        // Columns are valid only for a region within one line.
        Region::Text { start, end } if start.line == end.line => {
            format!(",line={0},endLine={0},col={1},endColumn={2}", start.line, start.column, end.column)
        }
        Region::Text { start, end } => format!(",line={},endLine={}", start.line, end.line),
    }
}

/// Escapes characters that would end the message, and characters that a log would not show.
fn data(text: &str) -> String {
    guarded(text).replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes characters that would end a property.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
