//! Results of tests as `JUnit` writes them, which GitLab, Jenkins and others show.
//!
//! Each finding is a case that failed, of the class `command.rule`: Jenkins groups by class and GitLab shows
//! the class as the suite. Its name says file and message but no line, since both recognise a case by class
//! and name, and a finding isn't a new one where lines have moved. Notes fail nothing. A rule without
//! findings is a case that passed, so that there is always one.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use super::{Entry, Place, Report};
use crate::diagnostic::Level;

/// Longest message in the name of a case, in characters: names stand in lists.
const MAX_NAME: usize = 200;

/// What a case is called that found nothing.
const NOTHING: &str = "nothing found";

pub(super) fn write(report: &Report) -> String {
    let mut suite = TestSuite::new(report.command);
    suite.add_test_cases(found(report));
    suite.add_test_cases(passed(report));
    let mut whole = quick_junit::Report::new(format!("uavspec {}", report.command));
    whole.add_test_suite(suite);
    // Writing to memory can't fail.
    whole.to_string().unwrap_or_default()
}

/// A case for each finding.
fn found(report: &Report) -> Vec<TestCase> {
    let mut seen: BTreeMap<(&str, String), usize> = BTreeMap::new();
    let case = |entry: &Entry| {
        let mut name = name(entry);
        let count = seen.entry((entry.rule, name.clone())).and_modify(|count| *count += 1).or_insert(1);
        if *count > 1 {
            // Of cases of the same name only one would be shown.
            let _ = write!(name, " ({count})");
        }
        case(report.command, entry, &name)
    };
    report.entries.iter().map(case).collect()
}

/// A case for each rule that found nothing; one for the command, where there is none else.
fn passed(report: &Report) -> Vec<TestCase> {
    let found: BTreeSet<&str> = report.entries.iter().map(|entry| entry.rule).collect();
    let is_passed = |class: String| {
        let mut case = TestCase::new(NOTHING, TestCaseStatus::success());
        case.set_classname(class);
        case
    };
    if report.rules.is_empty() && found.is_empty() {
        return vec![is_passed(report.command.to_owned())];
    }
    let rules = report.rules.iter().map(|rule| rule.id).filter(|rule| !found.contains(rule));
    rules.map(|rule| is_passed(class(report.command, rule))).collect()
}

fn class(command: &str, rule: &str) -> String {
    format!("{command}.{rule}")
}

fn case(command: &str, entry: &Entry, name: &str) -> TestCase {
    let text = visible(&text(entry));
    let mut case = if entry.level == Level::Note {
        let mut case = TestCase::new(name, TestCaseStatus::success());
        case.set_system_out(text);
        case
    } else {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message(one_line(&entry.message)).set_type(entry.rule).set_description(text);
        TestCase::new(name, status)
    };
    case.set_classname(class(command, entry.rule));
    // GitLab and others lead to the file by this.
    case.extra.insert("file".into(), visible(&entry.place.path).into());
    case.extra.insert("line".into(), entry.place.start.line.to_string().into());
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

/// All that is known of a finding.
fn text(entry: &Entry) -> String {
    let category = entry.category.map(|category| format!(" ({category})")).unwrap_or_default();
    let level = entry.level.name();
    let mut text = format!("{}: {level}[{}]{category}: {}\n", place(&entry.place), entry.rule, entry.message);
    let mut line = |label: &str, value: &str| {
        if !value.is_empty() {
            // Writing to a `String` can't fail.
            let _ = writeln!(text, "{label}: {value}");
        }
    };
    line("help", &entry.help);
    if let Some((Some(old), _)) = &entry.sides {
        line("before", &place(old));
    }
    entry.related.iter().for_each(|(at, label)| line(&place(at), label));
    line("see", &entry.url());
    text.truncate(text.trim_end().len());
    text
}

fn place(place: &Place) -> String {
    format!("{}:{}:{}", place.path, place.start.line, place.start.column)
}

/// A text on one line, as attributes want it.
fn one_line(text: &str) -> String {
    visible(&text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// A text of characters that XML can hold. The library would drop some of the others silently, and with them
/// what a message is about.
fn visible(text: &str) -> String {
    text.chars()
        .map(|character| match character {
            '\n' => '\n',
            '\t' => ' ',
            '\u{fffe}' | '\u{ffff}' => char::REPLACEMENT_CHARACTER,
            _ if character.is_control() => char::REPLACEMENT_CHARACTER,
            _ => character,
        })
        .collect()
}
