//! Renders reports with one line for each finding, as compilers do, so that editors and grep can read them:
//!
//! ```text
//! flight.ulg:byte 86,347: warning: PX-RANGE-01: battery_status.max_error: 0 is outside the range 1 to 100 (42 times)
//! run.jsonl:7: error: FW-UST-MODE: UAV-INF: /body/status/a/mode: expected a string, found 7
//! run.jsonl: error: does not conform: 1 MUST, 0 SHOULD
//! ```

use std::fmt::{self, Write as _};

use super::{About, Case, Finding, Outcome, OutcomeKind, Report, Subject, Verdict};
use crate::model::Location;
use crate::text::{Grouped, shown};

/// Renders a report.
pub(super) fn write(report: &Report) -> String {
    let mut text = String::new();
    for subject in &report.subjects {
        // Writing to a string can't fail.
        let _ = self::subject(subject, &mut text);
    }
    for file in &report.unreadable {
        let _ = writeln!(text, "{}: error: {}", shown(&file.path), shown(&file.message));
    }
    text
}

fn subject(subject: &Subject, text: &mut String) -> fmt::Result {
    let path = shown(&subject.path);
    for finding in &subject.findings {
        self::finding(subject, finding, text)?;
    }
    if let About::Testee(testee) = &subject.about {
        let failed = testee.cases.iter().filter(|case| case.verdict.is_failure() && case.known.is_none());
        for Case { name, verdict, expected, actual, .. } in failed {
            let (expected, actual) = (shown(expected), shown(actual));
            writeln!(
                text,
                "{path}: error: {}: {}: expected {expected}, found {actual}",
                shown(name),
                verdict.name()
            )?;
        }
    }
    for corruption in &subject.corruption {
        writeln!(text, "{path}:{}: warning: {}", place(corruption.location), shown(&corruption.message))?;
    }
    let Outcome { kind, .. } = subject.outcome;
    writeln!(text, "{path}: {}: {}", severity_of(kind), shown(&subject.outcome.last_line()))
}

fn finding(subject: &Subject, finding: &Finding, text: &mut String) -> fmt::Result {
    let Some(example) = finding.examples.first() else { return Ok(()) };
    let mut path = shown(&subject.path);
    if subject.is_readable_again {
        path = format!("{path}:{}", place(example.location));
    }
    let severity = match finding.verdict {
        Verdict::Fail => "error",
        Verdict::Warn => "warning",
        _ => "note",
    };
    let times =
        if finding.count > 1 { format!(" ({} times)", Grouped(finding.count)) } else { String::new() };
    writeln!(
        text,
        "{path}: {severity}: {}: {}: {}{times}",
        finding.rule,
        shown(&finding.subject),
        shown(&example.text())
    )
}

/// The location in the form that editors read: a line is only its number.
fn place(location: Location) -> String {
    match location {
        Location::Line(line) => line.to_string(),
        Location::Byte(_) | Location::Message(_) | Location::Channel(_) => location.to_string(),
    }
}

const fn severity_of(kind: OutcomeKind) -> &'static str {
    match kind {
        OutcomeKind::Conforms | OutcomeKind::Partial | OutcomeKind::Nothing => "note",
        OutcomeKind::Stale | OutcomeKind::Incomplete => "warning",
        OutcomeKind::DoesNotConform | OutcomeKind::Failed => "error",
    }
}
