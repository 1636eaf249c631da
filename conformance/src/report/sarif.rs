//! Renders reports as SARIF: one result per group of findings, at the location of the group's first finding.

use uavspec_codegen::diagnostic::Level;
use uavspec_codegen::report::{self as shared, Entry, Place, Region, RuleInfo};

use super::{
    About, Action, Case, CaseVerdict, Corruption, Definition, Finding, Outcome, OutcomeKind, Report,
    RuleReport, Subject, Testee, Verdict,
};
use crate::model::{self, Extent};
use crate::text::shown;

/// The id for corrupt and unreadable parts, and its description.
const CORRUPTION: (&str, &str) = ("damage", "Files can be read completely.");

/// The id for captures that weren't read or checked completely, and its description.
const INCOMPLETE: (&str, &str) = ("incomplete", "Files are read and checked completely.");

/// The id for topics, types and files that weren't checked, and its description.
const COVERAGE: (&str, &str) = ("coverage", "All topics and types are fully checked.");

/// The id for failures of the whole run, and its description.
const RUN: (&str, &str) = ("run", "Required rules are covered, and lists of known failures are up to date.");

/// The id for violations of the test protocol, and its description.
const PROTOCOL: (&str, &str) = ("protocol", "A testee implements the test protocol.");

pub(super) fn write(report: &Report) -> String {
    let command = match report.action {
        Action::Check => "check",
        Action::Test => "test",
        Action::Probe => "probe",
    };
    let mut entries = Vec::new();
    for subject in &report.subjects {
        entries.extend(subject.findings.iter().filter_map(|finding| finding_entry(subject, finding)));
        entries.extend(subject.corruption.iter().map(|corruption| corruption_entry(subject, corruption)));
        entries.extend(outcome_entries(subject));
        if let About::Testee(testee) = &subject.about {
            let failures = testee.cases.iter().filter(|case| case.verdict.is_failure());
            entries.extend(failures.map(|case| case_entry(subject, case)));
            entries.extend(protocol_entries(subject, testee));
        }
    }
    entries.extend(report.unreadable.iter().map(|unreadable| Entry {
        level: Level::Error,
        ..entry(CORRUPTION.0, Level::Error, &unreadable.message, whole_file(&unreadable.path))
    }));
    entries.extend(report.not_checked.iter().map(|file| {
        let message = format!("not checked: {}", file.message);
        entry(COVERAGE.0, Level::Note, &message, whole_file(&file.path))
    }));
    entries.extend(report.reasons.iter().map(|reason| {
        // SARIF results require a file.
        let first = report.subjects.first().map_or(".", |subject| &subject.path);
        let path = if reason.path.is_empty() { first } else { &reason.path };
        let region = reason.line.map_or(Region::Whole, Region::Line);
        entry(RUN.0, Level::Error, &reason.message, Place { path: path.to_owned(), region })
    }));
    let mut rules: Vec<RuleInfo> = report.rules.iter().map(rule).collect();
    let mut other = |(id, purpose): (&'static str, &'static str), level| {
        if entries.iter().any(|entry| entry.rule == id) {
            rules.push(RuleInfo { id: id.into(), purpose: purpose.into(), level, url: String::new() });
        }
    };
    other(CORRUPTION, Level::Note);
    other(INCOMPLETE, Level::Error);
    other(COVERAGE, Level::Note);
    other(RUN, Level::Error);
    other(PROTOCOL, Level::Error);
    for case in report.subjects.iter().flat_map(cases) {
        if rules.iter().all(|rule| rule.id != case.op) {
            let purpose = format!("Responses to `{}` are correct.", case.op);
            rules.push(RuleInfo {
                id: case.op.clone().into(),
                purpose: purpose.into(),
                level: Level::Error,
                url: String::new(),
            });
        }
    }
    shared::Report { command, rules, entries }.to_text(shared::Format::Sarif)
}

/// The failed cases of a subject.
fn cases(subject: &Subject) -> impl Iterator<Item = &Case> {
    let cases = match &subject.about {
        About::Testee(testee) => &testee.cases[..],
        About::Capture(_) => &[],
    };
    cases.iter().filter(|case| case.verdict.is_failure())
}

fn rule(rule: &RuleReport) -> RuleInfo {
    let level = match rule.level {
        model::Level::Must => Level::Error,
        model::Level::Should => Level::Warning,
        model::Level::Info => Level::Note,
    };
    RuleInfo { id: rule.id.into(), purpose: rule.statement.into(), level, url: rule.url.clone() }
}

fn finding_entry(subject: &Subject, finding: &Finding) -> Option<Entry> {
    let (first, others) = finding.examples.split_first()?;
    let level = match finding.verdict {
        _ if finding.known.is_some() => Level::Note,
        Verdict::Fail => Level::Error,
        Verdict::Warn => Level::Warning,
        _ => Level::Note,
    };
    let times = if finding.count == 1 { String::new() } else { format!("found {} times; ", finding.count) };
    let at = |location| Place { path: subject.path.clone(), region: region(location) };
    let mut related: Vec<(Place, String)> = others
        .iter()
        .map(|example| (at(example.location), format!("also: {}", shown(&example.text()))))
        .collect();
    related.extend(finding.definition.iter().map(defined));
    let message = format!("{}: {}", finding.subject, first.text());
    let facts = [
        ("expected", &first.expected),
        ("actual", &first.actual),
        ("excerpt", &first.excerpt),
        ("moment", &first.moment()),
        ("request", &first.request),
    ];
    let facts = facts.into_iter().filter(|(_, fact)| !fact.is_empty());
    Some(Entry {
        part: shown(&first.path),
        facts: facts.map(|(name, fact)| (name, shown(fact))).collect(),
        help: format!("{times}to reproduce: {}", shown(&finding.reproduce)),
        related,
        url: finding.url.clone(),
        ..entry(finding.rule, level, &message, at(first.location))
    })
}

/// The reasons why a capture is incomplete, or its partial coverage.
fn outcome_entries(subject: &Subject) -> Vec<Entry> {
    let Outcome { kind, text, .. } = &subject.outcome;
    if *kind == OutcomeKind::Partial {
        return vec![entry(COVERAGE.0, Level::Note, text, whole_file(&subject.path))];
    }
    let level = if subject.outcome.is_success() { Level::Note } else { Level::Error };
    let reasons = subject.incomplete.iter();
    reasons.map(|reason| entry(INCOMPLETE.0, level, reason, whole_file(&subject.path))).collect()
}

fn corruption_entry(subject: &Subject, corruption: &Corruption) -> Entry {
    let location = Place { path: subject.path.clone(), region: region(corruption.location) };
    let level = match subject.extent {
        Extent::Whole => Level::Note,
        Extent::EndsEarly | Extent::WithGaps => Level::Warning,
        Extent::Unreadable => Level::Error,
    };
    entry(CORRUPTION.0, level, &corruption.message, location)
}

fn case_entry(subject: &Subject, case: &Case) -> Entry {
    let message = match case.verdict {
        CaseVerdict::Fail if case.path.is_empty() => {
            format!("{}: expected {}, got {}", case.name, case.expected, case.actual)
        }
        CaseVerdict::Fail => {
            format!("{}: expected {} at {}, got {}", case.name, case.expected, case.path, case.actual)
        }
        _ => format!("{}: {}: {}", case.name, case.verdict.name(), case.message),
    };
    let level = if case.known.is_some() { Level::Note } else { Level::Error };
    // A testee has no file, so the location is in the definition.
    let location = case.definition.as_ref().map_or_else(|| whole_file(&subject.path), |line| defined(line).0);
    Entry {
        help: format!("{}; to reproduce: {}", case.description, shown(&case.reproduce)),
        ..entry(&case.op, level, &message, location)
    }
}

fn protocol_entries(subject: &Subject, testee: &Testee) -> Vec<Entry> {
    let remarks = testee.protocol_remarks.iter().map(|remark| remark.message.clone());
    let gave_up = testee.gave_up.iter().map(|reason| format!("the run ended early: {reason}"));
    remarks
        .chain(gave_up)
        .map(|text| entry(PROTOCOL.0, Level::Error, &text, whole_file(&subject.path)))
        .collect()
}

fn entry(rule: &str, level: Level, message: &str, location: Place) -> Entry {
    Entry {
        rule: rule.to_owned().into(),
        category: None,
        level,
        // Editors show the message next to the code, so it must be short and contain no control characters.
        message: shown(message),
        help: String::new(),
        place: location,
        part: String::new(),
        facts: Vec::new(),
        sides: None,
        related: Vec::new(),
        is_fixable: false,
        url: String::new(),
    }
}

fn whole_file(path: &str) -> Place {
    Place { path: path.to_owned(), region: Region::Whole }
}

pub(super) fn region(location: model::Location) -> Region {
    match location {
        model::Location::Byte(offset) => Region::Byte(offset),
        model::Location::Line(line) => Region::Line(line),
        model::Location::Message(_) | model::Location::Channel(_) => Region::Whole,
    }
}

fn defined(line: &Definition) -> (Place, String) {
    let location = Place { path: line.file.clone(), region: Region::Line(line.line) };
    (location, format!("defined as: {}", shown(line.text.trim())))
}
