//! For people, at a terminal.

mod flockwave;
mod mcap;
mod testee;

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};
use uavspec_codegen::emit::docs::markdown::plural;

use super::{About, Finding, FormatResult, Json, Known, Report, Subject, Ulog, Verdict};
use crate::model::{Extent, Level};
use crate::text::Grouped;
use crate::text::shown;

/// How many formats that differ are shown, and how many places of damage.
const MAX_SHOWN: usize = 8;

/// How wide the column of rules is at least.
const MIN_WIDTH: usize = 12;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// A whole report, with colours; a stream that knows drops them where they would not be shown.
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

/// What came of a subject, with colours.
pub fn subject(subject: &Subject) -> String {
    let mut text = String::new();
    let _ = match &subject.about {
        About::Ulog(log) => of_source(subject, &mut text, |text| {
            head(subject, log, text)?;
            formats(log, text)
        }),
        About::Json(found) => of_source(subject, &mut text, |text| json(subject, found, text)),
        About::Mcap(found) => of_source(subject, &mut text, |text| mcap::write(subject, found, text)),
        About::Flockwave(found) => {
            of_source(subject, &mut text, |text| flockwave::write(subject, found, text))
        }
        About::Testee(testee) => testee::write(subject, testee, &mut text),
    };
    text
}

fn of_source(
    subject: &Subject,
    text: &mut String,
    head: impl FnOnce(&mut String) -> std::fmt::Result,
) -> std::fmt::Result {
    head(text)?;
    damage(subject, text)?;
    for note in &subject.notes {
        writeln!(text, "note         {}", shown(note))?;
    }
    if !subject.notes.is_empty() {
        writeln!(text)?;
    }
    let width =
        subject.findings.iter().map(|found| found.rule.len()).max().unwrap_or_default().max(MIN_WIDTH);
    for level in [Level::Must, Level::Should, Level::Info] {
        // The formats that differ stand above already.
        let is_of_level = |found: &&Finding| found.level == level && found.rule != "PX-FMT-01";
        for found in subject.findings.iter().filter(is_of_level) {
            finding(found, width, text)?;
        }
    }
    verdicts(subject, text)
}

fn head(subject: &Subject, log: &Ulog, text: &mut String) -> std::fmt::Result {
    let firmware = log.firmware.as_deref().map_or_else(|| "unknown firmware".to_owned(), shown);
    writeln!(
        text,
        "{}  {firmware}, {}, {}, {}, {} ({} ms)\n",
        shown(&subject.path),
        duration(subject),
        plural(log.formats.len() as u64, "topic"),
        plural(subject.records, "record"),
        plural(log.dropouts, "dropout"),
        subject.elapsed,
    )
}

/// From the first to the last timestamp.
fn duration(subject: &Subject) -> String {
    let seconds = subject.duration_us / 1_000_000;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{} h {minutes} min", Grouped(hours)),
    }
}

fn json(subject: &Subject, found: &Json, text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "{}  {}, {} of {} ({} ms)\n",
        shown(&subject.path),
        plural(found.lines, "line"),
        plural(subject.records, "message"),
        plural(found.types, "type"),
        subject.elapsed,
    )?;
    let mut has_notes = false;
    let mut note = |word: &str, what: &dyn std::fmt::Display| {
        has_notes = true;
        writeln!(text, "{word:<12} {what}")
    };
    for dialect in &found.dialects {
        note("dialect", dialect)?;
    }
    if found.skipped > 0 {
        note("skipped", &format_args!("{} that publish nothing (rosbridge)", Grouped(found.skipped)))?;
    }
    if !found.undefined.is_empty() {
        let first: Vec<String> = found.undefined.iter().take(MAX_SHOWN).map(|name| shown(name)).collect();
        let more = found.undefined.len() - first.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        note("not defined", &format_args!("{}{more}", first.join(", ")))?;
    }
    if has_notes { writeln!(text) } else { Ok(()) }
}

fn formats(log: &Ulog, text: &mut String) -> std::fmt::Result {
    let of = |wanted| log.formats.iter().filter(move |format| format.result == wanted);
    let differing = of(FormatResult::Differs).count();
    writeln!(
        text,
        "definitions  {} of {} topics equal, {differing} differ, {} not defined",
        of(FormatResult::Equal).count(),
        log.formats.len(),
        of(FormatResult::Undefined).count(),
    )?;
    for format in of(FormatResult::Differs).take(MAX_SHOWN) {
        writeln!(text, "  differs    {}: {}", shown(&format.topic), shown(&format.message))?;
    }
    if differing > MAX_SHOWN {
        writeln!(text, "             … and {} more", differing - MAX_SHOWN)?;
    }
    writeln!(text)
}

fn damage(subject: &Subject, text: &mut String) -> std::fmt::Result {
    for damage in subject.damage.iter().take(MAX_SHOWN) {
        writeln!(text, "{WARN}damage{WARN:#}       {}: {}", damage.place, shown(&damage.message))?;
    }
    let more = subject.damages().saturating_sub(MAX_SHOWN as u64);
    if more > 0 {
        writeln!(text, "             … and {} more", Grouped(more))?;
    }
    if subject.damage.is_empty() { Ok(()) } else { writeln!(text) }
}

/// `width` is that of the column of rules.
fn finding(finding: &Finding, width: usize, text: &mut String) -> std::fmt::Result {
    let (style, word) = match (&finding.known, finding.verdict) {
        (Some(known), _) => (PLAIN, known.kind.as_str()),
        (None, Verdict::Fail) => (FAIL, "FAIL"),
        (None, Verdict::Warn) => (WARN, "warn"),
        (None, _) => (PLAIN, "info"),
    };
    let Some(first) = finding.examples.first() else { return Ok(()) };
    let times =
        if finding.count == 1 { "once".to_owned() } else { format!("{} times", Grouped(finding.count)) };
    writeln!(
        text,
        "{style}{word:<5}{style:#} {:<width$} {:<6} {}: {}",
        finding.rule,
        finding.level,
        shown(&finding.subject),
        shown(&first.told())
    )?;
    let defined = finding.definition.as_ref().map(|line| format!("   {line}")).unwrap_or_default();
    let indent = width + 15;
    writeln!(text, "{:indent$}{times}, first at {}{defined}", "", first.place)?;
    let known = finding.known.as_ref();
    known.map_or(Ok(()), |known| writeln!(text, "{:indent$}{known}", ""))
}

/// Why something is let stand.
impl fmt::Display for Known {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&shown(&self.reason))?;
        if let Some(date) = &self.expires {
            write!(formatter, " (until {date})")?;
        }
        self.link.as_ref().map_or(Ok(()), |link| write!(formatter, " {}", shown(link)))
    }
}

fn verdicts(subject: &Subject, text: &mut String) -> std::fmt::Result {
    let of = |verdict| subject.rules.iter().filter(move |rule| rule.verdict == verdict);
    let idle: Vec<&str> = of(Verdict::NotExercised).map(|rule| rule.id).collect();
    let idle = match idle.len() {
        0 => String::new(),
        count if count > MAX_SHOWN => format!("   not exercised {count}"),
        count => format!("   not exercised {count} ({})", idle.join(", ")),
    };
    writeln!(text, "{PASS}pass{PASS:#}  {} rules{idle}\n", subject.count(Verdict::Pass))?;
    let (failed, warned) = (subject.count(Verdict::Fail), subject.count(Verdict::Warn));
    let damaged = match (subject.extent, &subject.about) {
        (Extent::Whole, _) if subject.damage.is_empty() => "",
        (Extent::Whole, About::Ulog(_)) => ", and the log is damaged",
        (Extent::Whole, _) => ", and the file is damaged",
        (Extent::EndsEarly | Extent::WithGaps, _) => ", and not all can be read",
        (Extent::BrokenOff, _) => "; it could not be read to its end",
    };
    let known = subject.findings.iter().filter(|finding| finding.known.is_some()).count();
    let known = if known > 0 { format!(", {known} known") } else { String::new() };
    match (failed, warned) {
        (0, _) if subject.judged == 0 => writeln!(text, "nothing was judged{damaged}"),
        (0, 0) => writeln!(text, "conforms{known}{damaged}"),
        (0, _) => writeln!(text, "conforms, {warned} SHOULD to be looked at{known}{damaged}"),
        _ => writeln!(text, "does not conform: {failed} MUST, {warned} SHOULD{known}{damaged}"),
    }
}
