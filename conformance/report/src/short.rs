//! Renders reports with one line for each finding, as compilers do, so that editors and grep can read them:
//!
//! ```text
//! flight.ulg:byte 86,347: warning: PX-RANGE-01: battery_status.remaining: 1.4 is outside the range 0 to 1 (42 times)
//! run.jsonl:7: error: FW-UST-MODE: UAV-INF: /body/status/a/mode: expected a string, found 7
//! run.jsonl: error: does not conform: 1 MUST, 0 SHOULD
//! ```

use std::fmt::{self, Write as _};
use std::io::{self, Write};

use uavspec_model::Location;
use uavspec_model::text::{shown, thousands};
use uavspec_schema::terminal::guarded;

use super::kind::{Format, Parts};
use super::{About, Case, CaseVerdict, Finding, Outcome, OutcomeKind, Report, Subject, Verdict};

/// A report under construction.
pub(super) struct Short;

impl Format for Short {
    fn add(&mut self, subject: &Subject) -> String {
        let mut text = String::new();
        // Writing to a string can't fail.
        let _ = self::subject(subject, &mut text);
        guarded(&text).into_owned()
    }

    fn finish(self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        io::copy(parts, to)?;
        for file in &report.unreadable {
            let line = format!("{}: error: {}\n", shown(&file.path), shown(&file.message));
            to.write_all(guarded(&line).as_bytes())?;
        }
        for reason in &report.reasons {
            let program = if reason.path.is_empty() { "uavspec: " } else { "" };
            let place =
                reason.line.map(|line| format!("{}:{line}: ", shown(&reason.path))).unwrap_or_default();
            let line = format!("{program}{place}error: {}\n", shown(&reason.message));
            to.write_all(guarded(&line).as_bytes())?;
        }
        Ok(())
    }
}

pub(crate) fn subject(subject: &Subject, text: &mut String) -> fmt::Result {
    let path = shown(&subject.path);
    for finding in &subject.findings {
        self::finding(subject, finding, text)?;
    }
    if let About::Testee(testee) = &subject.about {
        let failed = testee.cases.iter().filter(|case| case.verdict.is_failure() && case.known.is_none());
        for Case { name, verdict, expected, actual, message, .. } in failed {
            let problem = match verdict {
                CaseVerdict::Fail => format!("expected {}, found {}", shown(expected), shown(actual)),
                _ => shown(message),
            };
            writeln!(text, "{path}: error: {}: {}: {problem}", shown(name), verdict.name())?;
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
        if finding.count > 1 { format!(" ({} times)", thousands(finding.count)) } else { String::new() };
    writeln!(
        text,
        "{path}: {severity}: {}: {}: {}{times}",
        finding.rule,
        shown(&finding.subject),
        shown(&example.text())
    )
}

/// The location in the form that editors read. A line is just its number.
fn place(location: Location) -> String {
    match location {
        Location::Line(line) => line.to_string(),
        Location::Byte(_) | Location::Message(_) | Location::Channel(_) | Location::Endpoint(_) => {
            location.to_string()
        }
    }
}

const fn severity_of(kind: OutcomeKind) -> &'static str {
    match kind {
        OutcomeKind::Conforms | OutcomeKind::Partial | OutcomeKind::Nothing => "note",
        OutcomeKind::Stale | OutcomeKind::Incomplete => "warning",
        OutcomeKind::DoesNotConform | OutcomeKind::Failed => "error",
    }
}
