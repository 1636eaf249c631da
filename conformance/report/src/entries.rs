//! The entries of formats for CI systems and editors: one for each group of findings, at the location of the group's
//! first finding.

use uavspec_lint::report::{Entry, Place, Region};
use uavspec_model::Extent;
use uavspec_model::text::shown;
use uavspec_schema::diagnostic::Level;

use super::{
    About, Case, CaseVerdict, Corruption, Definition, Finding, Outcome, OutcomeKind, Report, Subject, Testee,
    Verdict,
};

/// The id for corrupt and unreadable parts.
const CORRUPTION: &str = "corruption";

/// The id for captures that weren't read or checked completely.
const INCOMPLETE: &str = "incomplete";

/// The id for topics, types and files that weren't checked.
const COVERAGE: &str = "coverage";

/// The id for failures of the whole run.
const RUN: &str = "run";

/// The id for violations of the test protocol.
const PROTOCOL: &str = "protocol";

/// The ids that aren't rules, with their descriptions and levels.
pub(super) const OTHERS: [(&str, &str, Level); 5] = [
    (CORRUPTION, "Files can be read completely.", Level::Note),
    (INCOMPLETE, "Files are read and checked completely.", Level::Error),
    (COVERAGE, "All topics and types are fully checked.", Level::Note),
    (RUN, "Required rules are covered, and baselines are up to date.", Level::Error),
    (PROTOCOL, "A testee implements the test protocol.", Level::Error),
];

/// The entries of a subject.
pub(super) fn of_subject(subject: &Subject) -> Vec<Entry> {
    let findings = subject.findings.iter().filter_map(|finding| finding_entry(subject, finding));
    let corruption = subject.corruption.iter().map(|corruption| corruption_entry(subject, corruption));
    let mut entries: Vec<Entry> = findings.chain(corruption).chain(outcome_entries(subject)).collect();
    if let About::Testee(testee) = &subject.about {
        entries.extend(failed_cases(testee).map(|case| case_entry(subject, case)));
        entries.extend(protocol_entries(subject, testee));
    }
    entries
}

/// The failed cases of a testee.
pub(super) fn failed_cases(testee: &Testee) -> impl Iterator<Item = &Case> {
    testee.cases.iter().filter(|case| case.verdict.is_failure())
}

/// The entries that concern the run instead of a subject.
pub(super) fn of_run(report: &Report) -> Vec<Entry> {
    let unreadable = report
        .unreadable
        .iter()
        .map(|file| entry(CORRUPTION, Level::Error, &file.message, whole_file(&file.path)));
    let not_checked = report.not_checked.iter().map(|file| {
        let message = format!("not checked: {}", file.message);
        entry(COVERAGE, Level::Note, &message, whole_file(&file.path))
    });
    let reasons = report.reasons.iter().map(|reason| {
        // The formats require a file.
        let first = report.totals.first.as_ref().map_or(".", |first| &first.path);
        let path = if reason.path.is_empty() { first } else { &reason.path };
        let region = reason.line.map_or(Region::Whole, Region::Line);
        entry(RUN, Level::Error, &reason.message, place(path, region))
    });
    unreadable.chain(not_checked).chain(reasons).collect()
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
    let at = |location| place(&subject.path, region(location));
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
        return vec![entry(COVERAGE, Level::Note, text, whole_file(&subject.path))];
    }
    let level = if subject.outcome.is_success() { Level::Note } else { Level::Error };
    let reasons = subject.incomplete.iter();
    reasons.map(|reason| entry(INCOMPLETE, level, reason, whole_file(&subject.path))).collect()
}

fn corruption_entry(subject: &Subject, corruption: &Corruption) -> Entry {
    let location = place(&subject.path, region(corruption.location));
    let level = match subject.extent {
        Extent::Whole => Level::Note,
        Extent::EndsEarly | Extent::WithGaps => Level::Warning,
        Extent::Unreadable => Level::Error,
    };
    entry(CORRUPTION, level, &corruption.message, location)
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
        .map(|text| entry(PROTOCOL, Level::Error, &text, whole_file(&subject.path)))
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
    place(path, Region::Whole)
}

/// A region of a file. The path contains `/` on every system.
pub(super) fn place(path: &str, region: Region) -> Place {
    let path = if cfg!(windows) { path.replace('\\', "/") } else { path.to_owned() };
    Place { path, region }
}

pub(super) fn region(location: uavspec_model::Location) -> Region {
    match location {
        uavspec_model::Location::Byte(offset) => Region::Byte(offset),
        uavspec_model::Location::Line(line) => Region::Line(line),
        uavspec_model::Location::Message(_)
        | uavspec_model::Location::Channel(_)
        | uavspec_model::Location::Endpoint(_) => Region::Whole,
    }
}

fn defined(line: &Definition) -> (Place, String) {
    let location = place(&line.file, Region::Line(line.line));
    (location, format!("defined as: {}", shown(line.text.trim())))
}

#[cfg(test)]
mod tests {
    use super::{Region, place};

    #[test]
    fn places_contain_slashes_on_windows() {
        let path = place("logs\\a.ulg", Region::Whole).path;
        assert_eq!(path, if cfg!(windows) { "logs/a.ulg" } else { "logs\\a.ulg" });
    }
}
