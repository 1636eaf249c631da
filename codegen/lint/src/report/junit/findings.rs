//! Findings as test cases.
//!
//! Each warning or error is a failed case with the class `command.rule`, and each note is a passed case. Jenkins groups
//! cases by class, and GitLab displays the class as the suite. The name of a case consists of the file and the message.
//! Both tools identify a case by class and name. The name omits the line number, so a finding that moves to another
//! line is not shown as new. A rule without findings also counts as a passed case, so there is always at least one
//! case.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use uavspec_schema::diagnostic::Level;

use super::suite::{Case, Outcome, Reason, Suite, one_line, write as write_suites};
use crate::report::model::{Entry, Report};

/// The maximum number of characters of a message in a case name.
const MAX_NAME: usize = 200;

/// The name of a case without findings.
const NO_FINDINGS: &str = "no findings";

pub(in crate::report) fn write(report: &Report) -> String {
    let cases = found(report).into_iter().chain(passed(report)).collect();
    let suite = Suite { name: report.command.to_owned(), cases };
    write_suites(&format!("uavspec {}", report.command), &[suite])
}

/// One case for each finding.
fn found(report: &Report) -> Vec<Case> {
    let mut seen: BTreeMap<(&str, String), usize> = BTreeMap::new();
    let mut cases = Vec::with_capacity(report.entries.len());
    for entry in &report.entries {
        let mut name = name(entry);
        let count = seen.entry((&entry.rule, name.clone())).and_modify(|count| *count += 1).or_insert(1);
        if *count > 1 {
            // Number cases with the same name, because tools display only one of them.
            let _ = write!(name, " ({count})");
        }
        cases.push(case(report.command, entry, name));
    }
    cases
}

/// One passed case for each rule without findings. If the report has no rules and no findings, the only case is for the
/// command itself.
fn passed(report: &Report) -> Vec<Case> {
    let found: BTreeSet<&str> = report.entries.iter().map(|entry| &*entry.rule).collect();
    if report.rules.is_empty() && found.is_empty() {
        return vec![Case::passed(report.command, NO_FINDINGS)];
    }
    let rules = report.rules.iter().map(|rule| &*rule.id).filter(|rule| !found.contains(rule));
    rules.map(|rule| Case::passed(class(report.command, rule), NO_FINDINGS)).collect()
}

fn class(command: &str, rule: &str) -> String {
    format!("{command}.{rule}")
}

fn case(command: &str, entry: &Entry, name: String) -> Case {
    let mut case = Case::passed(class(command, &entry.rule), name);
    case.place = Some(entry.place.clone());
    if entry.level == Level::Note {
        case.output = text(entry);
    } else {
        let (kind, message) = (entry.rule.to_string(), entry.message.clone());
        case.outcome = Outcome::Failed(Reason { kind, message, text: text(entry) });
    }
    case
}

fn name(entry: &Entry) -> String {
    let message = one_line(&entry.message);
    let message = match message.char_indices().nth(MAX_NAME) {
        Some((cut, _)) => format!("{}…", &message[..cut]),
        None => message,
    };
    let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
    format!("{}: {message}{category}", one_line(&entry.place.path))
}

/// The full text of a finding.
fn text(entry: &Entry) -> String {
    let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
    let level = entry.level.name();
    let mut text = format!("{}: {level}[{}]{category}: {}\n", entry.place, entry.rule, entry.message);
    let mut line = |label: &str, value: &str| {
        if !value.is_empty() {
            // Writing to a `String` can't fail.
            let _ = writeln!(text, "{label}: {value}");
        }
    };
    line("help", &entry.help);
    if let Some((Some(old), _)) = &entry.sides {
        line("before", &old.to_string());
    }
    entry.related.iter().for_each(|(at, label)| line(&at.to_string(), label));
    line("see", &entry.url);
    text.truncate(text.trim_end().len());
    text
}
