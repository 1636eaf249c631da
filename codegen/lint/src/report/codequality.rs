//! The Code Quality format of GitLab, which shows findings in merge requests.
//!
//! Format: <https://docs.gitlab.com/ci/testing/code_quality/#code-quality-report-format>.

use std::io::{self, BufRead};

use serde_json::json;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::json_text;

use super::fingerprint::Fingerprints;
use super::model::{Entry, Place, Region, Report};

/// Creates the issues of a report, which may be written one at a time.
#[derive(Debug, Default)]
pub struct Issues {
    fingerprints: Fingerprints,
}

impl Issues {
    /// The issue for an entry, as a line of JSON.
    pub fn line(&mut self, entry: &Entry) -> String {
        let Place { path, region } = &entry.place;
        let issue = json!({
            "description": description(entry),
            "check_name": entry.rule,
            "fingerprint": self.fingerprints.of(entry),
            "severity": severity(entry.level),
            // GitLab requires a line.
            "location": { "path": path.trim_start_matches("./"), "lines": { "begin": region.line().unwrap_or(1) } },
        });
        json_text::compact(&issue) + "\n"
    }
}

/// Writes a report. `issues` are the lines of [`Issues`].
///
/// # Errors
/// Fails if the issues can't be read, or if `to` can't be written.
pub fn write_list(issues: impl BufRead, to: &mut dyn io::Write) -> io::Result<()> {
    let mut separator = "[\n";
    for line in issues.lines() {
        write!(to, "{separator}  {}", line?)?;
        separator = ",\n";
    }
    to.write_all(if separator == "[\n" { b"[]\n" } else { b"\n]\n" })
}

pub(super) fn write(report: &Report) -> String {
    let mut issues = Issues::default();
    let lines: String = report.entries.iter().map(|entry| issues.line(entry)).collect();
    let mut text = Vec::new();
    // Writing to memory can't fail.
    let written = write_list(lines.as_bytes(), &mut text);
    written.map_or_else(|_| String::new(), |()| String::from_utf8(text).unwrap_or_default())
}

/// The rule and the message, with the category of a change and the offset in a binary file.
fn description(entry: &Entry) -> String {
    let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
    let offset = match entry.place.region {
        Region::Byte(offset) => format!(" (byte {offset})"),
        _ => String::new(),
    };
    format!("{}: {}{category}{offset}", entry.rule, entry.message)
}

fn severity(level: Level) -> &'static str {
    match level {
        Level::Note => "info",
        Level::Warning => "minor",
        Level::Error => "major",
    }
}
