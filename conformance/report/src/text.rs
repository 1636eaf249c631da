//! Renders reports as text for a terminal.

mod findings;
mod skipped;
mod testee;

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::io::{self, Write};

use anstyle::{AnsiColor, Style};
use uavspec_check::{Describe, Line, List, MAX_LISTED as MAX_SHOWN, names};
use uavspec_model::Reason;
use uavspec_model::text::{plural, shown, thousands, wrapped};

use super::kind::{Format, Parts};
use super::{About, Outcome, OutcomeKind, Report, RequestType, Subject, Verdict};

/// The width of labels.
const LABEL: usize = 12;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// A report under construction, with colours.
pub(super) struct Text;

impl Format for Text {
    fn add(&mut self, subject: &Subject) -> String {
        self::subject(subject)
    }

    fn finish(self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        io::copy(parts, to)?;
        to.write_all(end(report).as_bytes())
    }
}

/// Renders the end of a report: the files without a section, the failures of the run, and the outcome of the run. The
/// outcome is left out if it is that of the only subject.
pub fn end(report: &Report) -> String {
    let mut text = String::new();
    let reasons: Vec<String> = report.reasons.iter().map(Reason::to_string).collect();
    let is_single = report.totals.is_single() && report.unreadable.is_empty() && reasons.is_empty();
    // Writing to a string can't fail.
    let _ = labelled(FAIL, "failed", &skipped::failures(&report.unreadable), &mut text);
    let _ = labelled(PLAIN, "not checked", &skipped::lines(&report.not_checked), &mut text);
    let _ = labelled(FAIL, "failed", &reasons, &mut text);
    if !is_single {
        let _ = outcomes(report, &mut text);
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

/// Writes the number of files with each outcome, and the outcome of the run.
fn outcomes(report: &Report, text: &mut String) -> fmt::Result {
    for kind in OutcomeKind::ALL {
        let (count, _) = report.totals.with(kind);
        if count > 0 {
            writeln!(text, "{:>6} {}", thousands(count), kind.name())?;
        }
    }
    writeln!(text, "{}", last_line(&report.outcome))
}

/// Renders the section of a subject, with colours.
pub fn subject(subject: &Subject) -> String {
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
    label(style(subject.outcome.kind), "outcome", &shown(&subject.outcome.last_line()), text)?;
    for line in subject.coverage_lines() {
        write_line(&line, text)?;
    }
    rules(subject, text)?;
    requests(&subject.requests, text)?;
    writeln!(text)?;
    lines(&subject.summary_lines(summary), text)?;
    corruption(subject, text)?;
    labelled(PLAIN, "note", &subject.notes, text)?;
    labelled(PLAIN, "remark", &subject.outcome.remarks, text)?;
    let shown_findings = findings::merged(subject);
    for merged in &shown_findings {
        findings::write(merged, subject, text)?;
    }
    if shown_findings.is_empty() { Ok(()) } else { writeln!(text, "\n{}", last_line(&subject.outcome)) }
}

/// Writes the rules by verdict. Lists the rules that have findings, with the number of findings.
fn rules(subject: &Subject, text: &mut String) -> fmt::Result {
    if subject.rules.is_empty() {
        return Ok(());
    }
    for (verdict, style) in
        [(Verdict::Fail, FAIL), (Verdict::Warn, WARN), (Verdict::Known, PLAIN), (Verdict::Shown, PLAIN)]
    {
        let with_verdict = subject.rules.iter().filter(|rule| rule.verdict == verdict);
        let named = with_verdict.map(|rule| match rule.findings {
            1 => rule.id.to_owned(),
            count => format!("{} ({})", rule.id, thousands(count)),
        });
        let named: Vec<String> = named.collect();
        if !named.is_empty() {
            label(style, verdict.name(), &named.join(", "), text)?;
        }
    }
    let [passed, uncovered] = [Verdict::Pass, Verdict::NotCovered].map(|verdict| subject.count(verdict));
    label(PASS, "pass", &format!("{}, {uncovered} not covered", plural(passed, "rule")), text)
}

/// Writes the number of request types that a probe has sent, and the reasons for not sending the others.
fn requests(requests: &[RequestType], text: &mut String) -> fmt::Result {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for request in requests {
        if let Some(reason) = &request.not_sent {
            reasons.entry(reason).or_default().push(&request.name);
        }
    }
    let sent = requests.iter().filter(|request| request.sent > 0).count();
    let refused =
        requests.iter().filter(|request| request.refused > 0 && request.refused == request.answered);
    let refused: Vec<&str> = refused.map(|request| request.name.as_str()).collect();
    if !requests.is_empty() {
        let counts = format!("{sent} of {} types sent, {} refused", requests.len(), refused.len());
        label(PLAIN, "requests", &counts, text)?;
    }
    if !refused.is_empty() {
        label(PLAIN, "  refused", &shown(&refused.join(", ")), text)?;
    }
    for (reason, types) in reasons {
        let listed = names(types.iter().copied());
        label(PLAIN, "  not sent", &format!("{listed} ({})", shown(reason)), text)?;
    }
    Ok(())
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
        write_line(line, text)?;
    }
    if lines.is_empty() { Ok(()) } else { writeln!(text) }
}

fn write_line(line: &Line, text: &mut String) -> fmt::Result {
    label(PLAIN, line.label, &line.text, text)?;
    for List { label, items } in &line.lists {
        for item in items.iter().take(MAX_SHOWN) {
            writeln!(text, "  {label:<10} {}", wrapped(item, LABEL + 1, LABEL + 3))?;
        }
        if items.len() > MAX_SHOWN {
            writeln!(text, "             … and {} more", items.len() - MAX_SHOWN)?;
        }
    }
    Ok(())
}

fn corruption(subject: &Subject, text: &mut String) -> fmt::Result {
    for corruption in subject.corruption.iter().take(MAX_SHOWN) {
        let content = format!("{}: {}", corruption.location, shown(&corruption.message));
        label(WARN, "corrupt", &content, text)?;
    }
    let more = subject.corrupt_count().saturating_sub(MAX_SHOWN as u64);
    if more > 0 {
        writeln!(text, "             … and {} more", thousands(more))?;
    }
    if subject.corruption.is_empty() { Ok(()) } else { writeln!(text) }
}

/// The last line of a section: the outcome, in its colour.
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
