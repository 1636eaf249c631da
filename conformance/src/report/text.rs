//! For people, at a terminal.

mod mcap;

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};

use super::Judged;
use crate::comparison::Comparison;
use crate::definitions::Definitions;
use crate::finding::{Group, Verdict};
use crate::judge::{JsonSource, LogSource, Source};
use crate::record::Grouped;
use crate::rule::{Level, RULES};

/// How many formats that differ are shown, and how many places of damage.
const MAX_SHOWN: usize = 8;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();
const PLAIN: Style = Style::new();

/// The judgement of a source, with colours; a stream that knows drops them where they would not be shown.
pub fn write(judged: &Judged, definitions: &Definitions) -> String {
    let mut text = String::new();
    // Writing to a string can't fail.
    let _ = match &judged.judgement.source {
        Source::Log(log) => head(judged, log, &mut text).and_then(|()| formats(&log.formats, &mut text)),
        Source::Json(found) => json(judged, found, &mut text),
        Source::Mcap(found) => mcap::write(judged, found, &mut text),
    };
    let _ = damage(judged, &mut text);
    for level in [Level::Must, Level::Should, Level::Info] {
        // The formats that differ stand above already.
        let is_of_level = |group: &&Group| group.rule.level == level && group.rule.id != "PX-FMT-01";
        for group in judged.judgement.findings.groups().filter(is_of_level) {
            let _ = finding(group, definitions, &mut text);
        }
    }
    let _ = verdicts(judged, &mut text);
    text
}

fn head(judged: &Judged, log: &LogSource, text: &mut String) -> std::fmt::Result {
    let judgement = &judged.judgement;
    let firmware = log.firmware.as_deref().unwrap_or("unknown firmware");
    let seconds = judgement.duration / 1_000_000;
    writeln!(
        text,
        "{}  {firmware}, {} min {} s, {} topics, {} records, {} dropouts ({} ms)\n",
        judged.path,
        seconds / 60,
        seconds % 60,
        log.formats.len(),
        Grouped(judgement.records),
        log.dropouts,
        judged.elapsed,
    )
}

fn json(judged: &Judged, found: &JsonSource, text: &mut String) -> std::fmt::Result {
    let records = judged.judgement.records;
    writeln!(
        text,
        "{}  {} {}, {} {} of {} {} ({} ms)\n",
        judged.path,
        Grouped(found.lines),
        if found.lines == 1 { "line" } else { "lines" },
        Grouped(records),
        if records == 1 { "message" } else { "messages" },
        found.types,
        if found.types == 1 { "type" } else { "types" },
        judged.elapsed,
    )?;
    let mut has_notes = false;
    let mut note = |word: &str, what: &dyn std::fmt::Display| {
        has_notes = true;
        writeln!(text, "{word:<12} {what}")
    };
    for dialect in found.dialects.iter() {
        note("dialect", &dialect)?;
    }
    if found.skipped > 0 {
        note("skipped", &format_args!("{} that publish nothing (rosbridge)", Grouped(found.skipped)))?;
    }
    if !found.undefined.is_empty() {
        let shown: Vec<&str> = found.undefined.iter().take(MAX_SHOWN).map(String::as_str).collect();
        let more = found.undefined.len() - shown.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        note("not defined", &format_args!("{}{more}", shown.join(", ")))?;
    }
    if has_notes { writeln!(text) } else { Ok(()) }
}

fn formats(formats: &[(String, Comparison)], text: &mut String) -> std::fmt::Result {
    let count = |wanted: fn(&Comparison) -> bool| formats.iter().filter(|(_, found)| wanted(found)).count();
    let equal = count(|found| *found == Comparison::Equal);
    let unknown = count(|found| *found == Comparison::Undefined);
    let differing: Vec<_> = formats
        .iter()
        .filter_map(|(name, found)| match found {
            Comparison::Differs(differences) => Some((name, differences)),
            Comparison::Equal | Comparison::Undefined => None,
        })
        .collect();
    writeln!(
        text,
        "definitions  {equal} of {} topics equal, {} differ, {unknown} not defined",
        formats.len(),
        differing.len()
    )?;
    for (name, differences) in differing.iter().take(MAX_SHOWN) {
        writeln!(text, "  differs    {name}: {differences}")?;
    }
    if differing.len() > MAX_SHOWN {
        writeln!(text, "             … and {} more", differing.len() - MAX_SHOWN)?;
    }
    writeln!(text)
}

fn damage(judged: &Judged, text: &mut String) -> std::fmt::Result {
    let judgement = &judged.judgement;
    for (place, what) in judgement.damage.iter().take(MAX_SHOWN) {
        writeln!(text, "{WARN}damage{WARN:#}       {place}: {what}")?;
    }
    let more = judgement.damage.len().saturating_sub(MAX_SHOWN) as u64 + judgement.more_damage;
    if more > 0 {
        writeln!(text, "             … and {} more", Grouped(more))?;
    }
    if judgement.damage.is_empty() { Ok(()) } else { writeln!(text) }
}

fn finding(group: &Group, definitions: &Definitions, text: &mut String) -> std::fmt::Result {
    let (style, word) = match (&group.known, group.rule.level) {
        (Some(known), _) => (PLAIN, known.kind.name()),
        (None, Level::Must) => (FAIL, "FAIL "),
        (None, Level::Should) => (WARN, "warn "),
        (None, Level::Info) => (PLAIN, "info "),
    };
    let Some((place, first)) = group.examples.first() else { return Ok(()) };
    let times = if group.count == 1 { "once".to_owned() } else { format!("{} times", Grouped(group.count)) };
    writeln!(
        text,
        "{style}{word}{style:#} {:<12} {:<6} {}: {first}",
        group.rule.id, group.rule.level, group.subject
    )?;
    let defined = group.definition.map(|span| format!("   {}", definitions.place(span))).unwrap_or_default();
    writeln!(text, "                           {times}, first at {place}{defined}")?;
    let known = group.known.as_ref();
    known.map_or(Ok(()), |known| writeln!(text, "                           {known}"))
}

fn verdicts(judged: &Judged, text: &mut String) -> std::fmt::Result {
    let findings = &judged.judgement.findings;
    let of = |verdict| RULES.iter().filter(move |rule| findings.verdict(rule) == verdict);
    let idle: Vec<&str> = of(Verdict::NotExercised).map(|rule| rule.id).collect();
    let idle = if idle.is_empty() {
        String::new()
    } else {
        format!("   not exercised {} ({})", idle.len(), idle.join(", "))
    };
    writeln!(text, "{PASS}pass{PASS:#}  {} rules{idle}\n", of(Verdict::Pass).count())?;
    let (failed, warned) = (of(Verdict::Fail).count(), of(Verdict::Warn).count());
    let known = findings.groups().filter(|group| group.known.is_some()).count();
    let known = if known > 0 { format!(", {known} known") } else { String::new() };
    let damaged = match &judged.judgement.source {
        _ if judged.judgement.damage.is_empty() => "",
        Source::Log(_) => ", and the log is damaged",
        Source::Json(_) => ", and not all can be read",
        Source::Mcap(_) => ", and the file is damaged",
    };
    match (failed, warned) {
        (0, _) if judged.judgement.judged == 0 => writeln!(text, "nothing was judged{damaged}"),
        (0, 0) => writeln!(text, "conforms{known}{damaged}"),
        (0, _) => writeln!(text, "conforms, {warned} SHOULD to be looked at{known}{damaged}"),
        _ => writeln!(text, "does not conform: {failed} MUST, {warned} SHOULD{known}{damaged}"),
    }
}
