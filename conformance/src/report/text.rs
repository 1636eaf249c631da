//! Renders reports as text for a terminal.

mod testee;

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};

use super::{About, Finding, Known, Outcome, OutcomeKind, Report, Subject, Verdict};
use crate::check::{Describe, Line, List, MAX_LISTED as MAX_SHOWN, names};
use crate::model::Level;
use crate::rules::px4;
use crate::text::{Grouped, shown, wrapped};

/// The minimum width of the rule column.
const MIN_WIDTH: usize = 12;

/// The width of labels.
const LABEL: usize = 12;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// Renders a whole report, with colours.
pub(super) fn write(report: &Report) -> String {
    let mut text: String = report.subjects.iter().map(subject).collect();
    text.push_str(&end(report));
    text
}

/// Renders the end of a report: the files without a section, and the outcome of a run with several files.
pub(crate) fn end(report: &Report) -> String {
    let mut text = String::new();
    let is_single = report.subjects.len() == 1 && report.unreadable.is_empty();
    let failed = report.unreadable.iter().map(|file| format!("{}: {}", file.path, file.message));
    // Writing to a string can't fail.
    let _ = labelled(FAIL, "failed", &failed.collect::<Vec<_>>(), &mut text);
    if let Some(first) = report.not_checked.first() {
        let files = names(report.not_checked.iter().map(|file| &*file.path));
        let _ = labelled(PLAIN, "not checked", &[format!("{files} ({})", first.message)], &mut text);
    }
    if !is_single {
        let _ = outcomes(report, &mut text);
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

/// Writes the number of files with each outcome, and the outcome of the run.
fn outcomes(report: &Report, text: &mut String) -> fmt::Result {
    for kind in OutcomeKind::ALL {
        let count = report.subjects.iter().filter(|subject| subject.outcome.kind == kind).count();
        if count > 0 {
            writeln!(text, "{:>6} {}", Grouped(count as u64).to_string(), kind.name())?;
        }
    }
    writeln!(text, "{}", last_line(&report.outcome))
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
    writeln!(text, "{}\n", wrapped(&format!("{}  {facts} ({elapsed} ms)", shown(&subject.path)), 0, 2))?;
    lines(&subject.coverage_lines(), text)?;
    lines(&summary.lines(), text)?;
    corruption(subject, text)?;
    labelled(PLAIN, "note", &subject.notes, text)?;
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

/// Writes a line that starts with a label.
fn label(style: Style, label: &str, content: &str, text: &mut String) -> fmt::Result {
    let content = wrapped(content, LABEL + 1, LABEL + 1);
    writeln!(text, "{style}{label}{style:#}{:width$} {content}", "", width = LABEL - label.len())
}

/// Writes a line for each item, and an empty line.
fn labelled(style: Style, name: &str, items: &[String], text: &mut String) -> fmt::Result {
    for item in items {
        label(style, name, &shown(item), text)?;
    }
    if items.is_empty() { Ok(()) } else { writeln!(text) }
}

fn lines(lines: &[Line], text: &mut String) -> fmt::Result {
    for line in lines {
        label(PLAIN, line.label, &line.text, text)?;
        for List { label, items } in &line.lists {
            for item in items.iter().take(MAX_SHOWN) {
                writeln!(text, "  {label:<10} {}", wrapped(item, LABEL + 1, LABEL + 3))?;
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
        let content = format!("{}: {}", corruption.location, shown(&corruption.message));
        label(WARN, "corrupt", &content, text)?;
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
    let indent = width + 14;
    let content = format!("{}: {}", shown(&finding.subject), shown(&first.text()));
    let content = wrapped(&content, indent, indent);
    writeln!(text, "{style}{word:<5}{style:#} {:<width$} {:<6} {content}", finding.rule, finding.level)?;
    let defined = finding.definition.as_ref().map(|line| format!("   {line}")).unwrap_or_default();
    let place = wrapped(&format!("{times} {}{defined}", first.location), indent, indent);
    writeln!(text, "{:indent$}{place}", "")?;
    let known = finding.known.as_ref().map(|known| wrapped(&known.to_string(), indent, indent));
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
    if !subject.rules.is_empty() {
        let uncovered = subject.rules.iter().filter(|rule| rule.verdict == Verdict::NotCovered);
        let uncovered: Vec<&str> = uncovered.map(|rule| rule.id).collect();
        let uncovered = match uncovered.len() {
            0 => String::new(),
            count if count > MAX_SHOWN => format!("   not covered {count}"),
            count => format!("   not covered {count} ({})", uncovered.join(", ")),
        };
        let passed = format!("{} rules{uncovered}", subject.count(Verdict::Pass));
        writeln!(text, "{PASS}pass{PASS:#}  {}\n", wrapped(&passed, 6, 6))?;
    }
    labelled(PLAIN, "remark", &subject.outcome.remarks, text)?;
    writeln!(text, "{}", last_line(&subject.outcome))
}

/// The last line of a section: the outcome in its colour.
fn last_line(outcome: &Outcome) -> String {
    let style = style(outcome.kind);
    format!("{style}{}{style:#}", wrapped(&shown(&outcome.last_line()), 0, 2))
}

const fn style(kind: OutcomeKind) -> Style {
    match kind {
        OutcomeKind::Conforms | OutcomeKind::Partial => PASS,
        OutcomeKind::Nothing | OutcomeKind::Stale | OutcomeKind::Incomplete => WARN,
        OutcomeKind::DoesNotConform | OutcomeKind::Failed => FAIL,
    }
}
