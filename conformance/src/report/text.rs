//! Renders reports as text for a terminal.

mod testee;

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};

use super::{About, Finding, Known, Report, Subject, Verdict};
use crate::check::{Describe, Line, List, MAX_LISTED as MAX_SHOWN};
use crate::model::Level;
use crate::rules::px4;
use crate::text::Grouped;
use crate::text::shown;

/// The minimum width of the rule column.
const MIN_WIDTH: usize = 12;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// Renders a whole report, with colours.
pub(super) fn write(report: &Report) -> String {
    let mut text: String = report.subjects.iter().map(subject).collect();
    for unreadable in &report.unreadable {
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{FAIL}unreadable{FAIL:#}  {}: {}",
            shown(&unreadable.path),
            shown(&unreadable.message)
        );
    }
    text
}

/// Renders the section of a subject, with colours.
pub(crate) fn subject(subject: &Subject) -> String {
    let mut text = String::new();
    let _ = match &subject.about {
        About::Capture(summary) => capture(subject, summary.describe(), &mut text),
        About::Testee(testee) => testee::write(subject, testee, &mut text),
    };
    text
}

fn capture(subject: &Subject, summary: &dyn Describe, text: &mut String) -> fmt::Result {
    let (facts, elapsed) = (summary.facts(subject.totals()).join(", "), subject.elapsed);
    writeln!(text, "{}  {facts} ({elapsed} ms)\n", shown(&subject.path))?;
    lines(&summary.lines(), text)?;
    corruption(subject, text)?;
    for note in &subject.notes {
        writeln!(text, "note         {}", shown(note))?;
    }
    if !subject.notes.is_empty() {
        writeln!(text)?;
    }
    let width =
        subject.findings.iter().map(|found| found.rule.len()).max().unwrap_or_default().max(MIN_WIDTH);
    for level in [Level::Must, Level::Should, Level::Info] {
        // Format differences are listed in the summary instead.
        let is_of_level = |found: &&Finding| found.level == level && found.rule != px4::FMT_01.rule.id;
        for found in subject.findings.iter().filter(is_of_level) {
            finding(found, width, text)?;
        }
    }
    verdicts(subject, text)
}

fn lines(lines: &[Line], text: &mut String) -> fmt::Result {
    for line in lines {
        writeln!(text, "{:<12} {}", line.label, line.text)?;
        for List { label, items } in &line.lists {
            for item in items.iter().take(MAX_SHOWN) {
                writeln!(text, "  {label:<10} {item}")?;
            }
            if items.len() > MAX_SHOWN {
                writeln!(text, "             … and {} more", items.len() - MAX_SHOWN)?;
            }
        }
    }
    if lines.is_empty() { Ok(()) } else { writeln!(text) }
}

fn corruption(subject: &Subject, text: &mut String) -> fmt::Result {
    for corruption in subject.corruption.iter().take(MAX_SHOWN) {
        writeln!(text, "{WARN}corrupt{WARN:#}      {}: {}", corruption.location, shown(&corruption.message))?;
    }
    let more = subject.corrupt_count().saturating_sub(MAX_SHOWN as u64);
    if more > 0 {
        writeln!(text, "             … and {} more", Grouped(more))?;
    }
    if subject.corruption.is_empty() { Ok(()) } else { writeln!(text) }
}

/// Writes a finding. `width` is the width of the rule column.
fn finding(finding: &Finding, width: usize, text: &mut String) -> fmt::Result {
    let (style, word) = match (&finding.known, finding.verdict) {
        (Some(known), _) => (PLAIN, known.kind.as_str()),
        (None, Verdict::Fail) => (FAIL, "FAIL"),
        (None, Verdict::Warn) => (WARN, "warn"),
        (None, _) => (PLAIN, "info"),
    };
    let Some(first) = finding.examples.first() else { return Ok(()) };
    let times = if finding.count == 1 {
        "once, at".to_owned()
    } else {
        format!("{} times, first at", Grouped(finding.count))
    };
    writeln!(
        text,
        "{style}{word:<5}{style:#} {:<width$} {:<6} {}: {}",
        finding.rule,
        finding.level,
        shown(&finding.subject),
        shown(&first.text())
    )?;
    let defined = finding.definition.as_ref().map(|line| format!("   {line}")).unwrap_or_default();
    let indent = width + 15;
    writeln!(text, "{:indent$}{times} {}{defined}", "", first.location)?;
    let known = finding.known.as_ref();
    known.map_or(Ok(()), |known| writeln!(text, "{:indent$}{known}", ""))
}

impl fmt::Display for Known {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&shown(&self.reason))?;
        if let Some(date) = &self.expires {
            write!(formatter, " (until {date})")?;
        }
        self.link.as_ref().map_or(Ok(()), |link| write!(formatter, " {}", shown(link)))
    }
}

fn verdicts(subject: &Subject, text: &mut String) -> fmt::Result {
    let uncovered = subject.rules.iter().filter(|rule| rule.verdict == Verdict::NotCovered);
    let uncovered: Vec<&str> = uncovered.map(|rule| rule.id).collect();
    let uncovered = match uncovered.len() {
        0 => String::new(),
        count if count > MAX_SHOWN => format!("   not covered {count}"),
        count => format!("   not covered {count} ({})", uncovered.join(", ")),
    };
    writeln!(text, "{PASS}pass{PASS:#}  {} rules{uncovered}\n", subject.count(Verdict::Pass))?;
    writeln!(text, "{}", subject.outcome.last_line())
}
