//! The results of a testee, as text.

use std::fmt::{self, Write as _};

use uavspec_model::text::{shown, wrapped};

use super::{FAIL, PLAIN, WARN, label, last_line};
use crate::{Case, CaseVerdict, Counts, Subject, Testee};

/// The maximum number of failures shown, and the maximum number of standard error lines shown per failure.
const MAX_SHOWN: usize = 20;

pub(super) fn write(subject: &Subject, testee: &Testee, text: &mut String) -> fmt::Result {
    let space = if testee.version.is_empty() { "" } else { " " };
    writeln!(text, "{}{space}{}\n", shown(&subject.path), shown(&testee.version))?;
    super::lines(&subject.coverage_lines(), text)?;
    let failures = || testee.cases.iter().filter(|case| case.verdict.is_failure() && case.known.is_none());
    for case in failures().take(MAX_SHOWN) {
        failure(case, text)?;
    }
    let more = failures().count().saturating_sub(MAX_SHOWN);
    if more > 0 {
        writeln!(text, "… and {more} more; --format json lists them all\n")?;
    }
    let known = || testee.cases.iter().filter_map(|case| Some((case, case.known.as_ref()?)));
    for (case, known) in known().take(MAX_SHOWN) {
        writeln!(text, "{} {}: {known}", known.kind, shown(&case.name))?;
    }
    let more = known().count().saturating_sub(MAX_SHOWN);
    if more > 0 {
        writeln!(text, "… and {more} more known failures")?;
    }
    for remark in &testee.protocol_remarks {
        let times = if remark.count > 1 { format!(" ({} times)", remark.count) } else { String::new() };
        writeln!(text, "{WARN}protocol{WARN:#} {}{times}", shown(&remark.message))?;
    }
    if testee.more_protocol_remarks > 0 {
        writeln!(text, "{WARN}protocol{WARN:#} … and {} more", testee.more_protocol_remarks)?;
    }
    if known().next().is_some() || !testee.protocol_remarks.is_empty() {
        writeln!(text)?;
    }
    table(testee, text)?;
    let Counts { passed, failed, known, unsupported, not_run } = testee.counts;
    let known = if known > 0 { format!(" {known} known,") } else { String::new() };
    let counts = format!(
        "{passed} passed, {failed} failed,{known} {unsupported} unsupported, {not_run} not run, {} restarts",
        testee.restarts
    );
    writeln!(text, "\n{}\n{}", wrapped(&counts, 0, 2), last_line(&subject.outcome))
}

/// Writes the counts of each operation and type that the testee supports.
fn table(testee: &Testee, text: &mut String) -> fmt::Result {
    if testee.supported().next().is_some() {
        writeln!(text, "{:<16} {:<32} {:>6} {:>6} {:>11}", "op", "type", "pass", "fail", "unsupported")?;
    }
    for row in testee.supported() {
        let Counts { passed, failed, known, unsupported, not_run } = row.counts;
        let (op, type_name) = (shown(&row.op), shown(&row.type_name));
        writeln!(text, "{op:<16} {type_name:<32} {passed:>6} {failed:>6} {unsupported:>11}")?;
        if known + not_run > 0 {
            writeln!(text, "{:<16} {known} known, {not_run} not run", "")?;
        }
    }
    let unsupported = testee.unsupported_lines();
    if !unsupported.is_empty() {
        writeln!(text)?;
    }
    for line in unsupported {
        label(PLAIN, "unsupported", &line, text)?;
    }
    Ok(())
}

fn failure(case: &Case, text: &mut String) -> fmt::Result {
    let (verdict, name) = (case.verdict.name(), shown(&case.name));
    writeln!(text, "{FAIL}{verdict}{FAIL:#} {name}: {}", shown(&case.description))?;
    if case.verdict == CaseVerdict::Fail {
        let location = if case.path.is_empty() { "the response".to_owned() } else { shown(&case.path) };
        writeln!(text, "  at       {location}")?;
        writeln!(text, "  expected {}\n  got      {}", shown(&case.expected), shown(&case.actual))?;
    } else {
        writeln!(text, "  {}", shown(&case.message))?;
        let lines: Vec<&str> = case.stderr.lines().collect();
        for line in lines.iter().skip(lines.len().saturating_sub(MAX_SHOWN)) {
            writeln!(text, "  | {}", shown(line))?;
        }
    }
    writeln!(text)
}
