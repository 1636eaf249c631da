//! What came of asking, for people and for programs.

use std::fmt::{self, Write as _};

use anstyle::{AnsiColor, Style};
use serde_json::{Value, json};

use super::case::Case;
use super::outcome::{Counts, Outcome, Verdict};
use crate::report::excuse_to_json;

/// How many failures are shown to people, and how many lines of standard error.
const MAX_SHOWN: usize = 20;

/// The version of the JSON form; it rises when a member changes its meaning or goes.
const VERSION: u32 = 1;

const FAIL: Style = AnsiColor::Red.on_default().bold();
const WARN: Style = AnsiColor::Yellow.on_default().bold();
const PASS: Style = AnsiColor::Green.on_default().bold();

/// For people, with colours; a stream that knows drops them where they would not be shown.
pub fn to_text(outcome: &Outcome<'_>) -> String {
    let mut text = String::new();
    // Writing to a string can't fail.
    let _ = write_text(outcome, &mut text);
    text
}

fn write_text(outcome: &Outcome<'_>, text: &mut String) -> fmt::Result {
    if let Some(hello) = &outcome.hello {
        writeln!(text, "{hello}\n")?;
    }
    for (case, verdict) in outcome.failures().take(MAX_SHOWN) {
        failure(case, verdict, text)?;
    }
    let counts = outcome.counts();
    if counts.failed > MAX_SHOWN {
        writeln!(text, "… and {} more; --format json lists them all\n", counts.failed - MAX_SHOWN)?;
    }
    for (case, excuse) in outcome.known().take(MAX_SHOWN) {
        writeln!(text, "{} {}: {excuse}", excuse.kind, case.name())?;
    }
    if counts.known > MAX_SHOWN {
        writeln!(text, "… and {} more that are known", counts.known - MAX_SHOWN)?;
    }
    for (remark, count) in &outcome.manners.remarks {
        let times = if *count > 1 { format!(" ({count} times)") } else { String::new() };
        writeln!(text, "{WARN}manners{WARN:#} {remark}{times}")?;
    }
    if outcome.manners.more > 0 {
        writeln!(text, "{WARN}manners{WARN:#} … and {} more", outcome.manners.more)?;
    }
    writeln!(text, "\n{:<18} {:<32} {:>6} {:>6} {:>11}", "op", "type", "pass", "fail", "unsupported")?;
    for ((action, type_name), counts) in outcome.table() {
        let Counts { passed, failed, known, unsupported, not_run } = counts;
        let mut rest = if known > 0 { format!("  {known} known") } else { String::new() };
        if not_run > 0 {
            write!(rest, "  {not_run} not run")?;
        }
        writeln!(text, "{action:<18} {type_name:<32} {passed:>6} {failed:>6} {unsupported:>11}{rest}")?;
    }
    let Counts { passed, failed, known, unsupported, not_run } = counts;
    let known = if known > 0 { format!(" {known} known,") } else { String::new() };
    writeln!(
        text,
        "\n{passed} passed, {failed} failed,{known} {unsupported} unsupported, {not_run} not run, {} restarts",
        outcome.restarts
    )?;
    match &outcome.gave_up {
        Some(why) => writeln!(text, "{FAIL}broken{FAIL:#}: {why}"),
        None if failed > 0 => writeln!(text, "{FAIL}does not conform{FAIL:#}"),
        None if !outcome.manners.are_good() => writeln!(text, "{FAIL}breaks the protocol{FAIL:#}"),
        None if passed == 0 && counts.known == 0 => writeln!(text, "{WARN}nothing was checked{WARN:#}"),
        None => writeln!(text, "{PASS}conforms{PASS:#}"),
    }
}

fn failure(case: &Case, verdict: &Verdict, text: &mut String) -> fmt::Result {
    writeln!(text, "{FAIL}{}{FAIL:#} {}: {}", verdict.name(), case.name(), case.description)?;
    match verdict {
        Verdict::Fail(difference) => {
            let place = if difference.path.is_empty() { "the answer" } else { &difference.path };
            writeln!(text, "  at       {place}")?;
            writeln!(text, "  expected {}\n  got      {}", difference.expected, difference.actual)?;
        }
        Verdict::Crashed { how, stderr } => {
            writeln!(text, "  {how}")?;
            evidence(stderr, text)?;
        }
        Verdict::TimedOut { after, stderr } => {
            writeln!(text, "  no answer within {} s", after.as_secs_f32())?;
            evidence(stderr, text)?;
        }
        // Only what counts as a failure is shown so.
        Verdict::Pass | Verdict::Known { .. } | Verdict::Unsupported | Verdict::NotRun => {}
    }
    writeln!(text)
}

fn evidence(stderr: &str, text: &mut String) -> fmt::Result {
    let lines: Vec<&str> = stderr.lines().collect();
    for line in lines.iter().skip(lines.len().saturating_sub(MAX_SHOWN)) {
        writeln!(text, "  | {}", line.escape_debug())?;
    }
    Ok(())
}

/// For programs. Cases that passed are counted, all others listed.
pub fn to_json(outcome: &Outcome<'_>) -> String {
    let counts = |counts: Counts| {
        json!({
            "pass": counts.passed, "fail": counts.failed, "known": counts.known,
            "unsupported": counts.unsupported, "not_run": counts.not_run,
        })
    };
    let table: Vec<Value> = outcome
        .table()
        .into_iter()
        .map(|((action, type_name), found)| json!({ "op": action, "type": type_name, "counts": counts(found) }))
        .collect();
    let listed = outcome.verdicts.iter().filter(|(_, verdict)| *verdict != Verdict::Pass);
    let remarks = outcome.manners.remarks.iter();
    let report = json!({
        "version": VERSION,
        "testee": outcome.hello.as_ref().map(|hello| json!({ "name": hello.name, "version": hello.version })),
        "counts": counts(outcome.counts()),
        "table": table,
        "cases": listed.map(|(case, verdict)| of_case(case, verdict)).collect::<Vec<Value>>(),
        "manners": remarks.map(|(what, count)| json!({ "message": what, "count": count })).collect::<Vec<Value>>(),
        "more_manners": outcome.manners.more,
        "restarts": outcome.restarts,
        "gave_up": outcome.gave_up,
    });
    // Values of this kind can always be written.
    serde_json::to_string_pretty(&report).map_or_else(|_| String::new(), |text| text + "\n")
}

fn of_case(case: &Case, verdict: &Verdict) -> Value {
    let mut value = json!({
        "case": case.name(), "description": case.description, "rule": case.rule, "verdict": verdict.name(),
    });
    match verdict {
        Verdict::Fail(difference) => {
            value["path"] = difference.path.clone().into();
            value["expected"] = difference.expected.clone().into();
            value["actual"] = difference.actual.clone().into();
        }
        Verdict::Crashed { how, stderr } => {
            value["message"] = how.clone().into();
            value["stderr"] = stderr.clone().into();
        }
        Verdict::TimedOut { after, stderr } => {
            value["after"] = after.as_secs_f64().into();
            value["stderr"] = stderr.clone().into();
        }
        Verdict::Known { failure, excuse } => {
            value = of_case(case, failure);
            value["known"] = excuse_to_json(excuse);
        }
        Verdict::Pass | Verdict::Unsupported | Verdict::NotRun => {}
    }
    value
}
