//! Renders reports as `JUnit` XML: one suite for each subject. A capture has one case for each rule. A testee has one
//! case for each test case.
//!
//! CI systems identify a case by class and name, so neither depends on the findings.

use std::fmt::Write as _;
use std::io::{self, Write};

use uavspec_lint::report::Region;
use uavspec_lint::report::junit::{self, Outcome, Reason, Suite};
use uavspec_model::Rule;
use uavspec_model::text::shown;
use uavspec_rules::rule;
use uavspec_schema::terminal::guarded;

use super::entries::{place, region};
use super::kind::{Format, Parts};
use super::{
    About, Action, Case, CaseVerdict, Finding, OutcomeKind, Report, RuleVerdict, Subject, Testee, Unreadable,
    Verdict,
};

/// The maximum number of findings in the text of a case.
const MAX_FINDINGS: usize = 20;

/// A report under construction.
#[derive(Debug, Default)]
pub(super) struct Junit(junit::Counts);

impl Junit {
    fn text(&mut self, suite: &Suite) -> String {
        guarded(&self.0.add(suite)).into_owned()
    }
}

impl Format for Junit {
    fn add(&mut self, subject: &Subject) -> String {
        self.text(&suite(subject))
    }

    fn finish(mut self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        let name = match report.action {
            Action::Check => "uavspec check",
            Action::Test => "uavspec test",
            Action::Probe => "uavspec probe",
        };
        let mut rest = String::new();
        for file in &report.unreadable {
            let (kind, message) = ("unreadable".to_owned(), shown(&file.message));
            let reason = Reason { kind, message: message.clone(), text: message };
            rest += &self.text(&file_suite(file, Outcome::Error(reason)));
        }
        for file in &report.not_checked {
            rest += &self.text(&file_suite(file, Outcome::Skipped(shown(&file.message))));
        }
        if let Some(suite) = run_suite(name, &report.reasons) {
            rest += &self.text(&suite);
        }
        let (start, end) = self.0.document(name);
        to.write_all(start.as_bytes())?;
        io::copy(parts, to)?;
        write!(to, "{rest}{end}")
    }
}

/// The suite for a file that wasn't read.
fn file_suite(file: &Unreadable, outcome: Outcome) -> Suite {
    let name = shown(&file.path);
    let case = junit::Case { outcome, ..junit::Case::passed(&name, READABLE) };
    Suite { name, cases: vec![case] }
}

/// The suite for reasons for failure that concern no subject.
fn run_suite(name: &str, reasons: &[uavspec_model::Reason]) -> Option<Suite> {
    let messages: Vec<String> = reasons.iter().map(|reason| shown(&reason.to_string())).collect();
    let (kind, message) = ("run".to_owned(), messages.first()?.clone());
    let outcome = Outcome::Failed(Reason { kind, message, text: messages.join("\n") });
    let case = junit::Case { outcome, ..junit::Case::passed(name, "as a whole") };
    Some(Suite { name: name.to_owned(), cases: vec![case] })
}

/// The name of the case for corrupt and unreadable parts.
const READABLE: &str = "can be read";

fn suite(subject: &Subject) -> Suite {
    let cases = match &subject.about {
        About::Testee(testee) => testee_cases(subject, testee),
        About::Capture(_) => {
            let rule_cases =
                subject.rules.iter().filter_map(|found| Some(rule_case(subject, rule(found.id)?, found)));
            std::iter::once(readable(subject)).chain(rule_cases).collect()
        }
    };
    Suite { name: shown(&subject.path), cases }
}

/// The case for the completeness of a capture. Its output is the outcome, the coverage and the corrupt parts.
///
/// An incomplete capture is an error, unless the user allows it.
fn readable(subject: &Subject) -> junit::Case {
    let mut case = junit::Case::passed(shown(&subject.path), READABLE);
    let mut corruption = String::new();
    for found in &subject.corruption {
        // Writing to a string can't fail.
        let _ = writeln!(corruption, "{}: {}", found.location, shown(&found.message));
    }
    if subject.more_corruption > 0 {
        let _ = writeln!(corruption, "… and {} more", subject.more_corruption);
    }
    let _ = writeln!(case.output, "outcome: {}", shown(&subject.outcome.last_line()));
    for line in subject.coverage_lines() {
        let _ = writeln!(case.output, "{}: {}", line.label, shown(&line.text));
    }
    let reasons = shown(&subject.incomplete.join("; "));
    if subject.incomplete.is_empty() {
        case.output += &corruption;
    } else if subject.outcome.is_success() {
        case.output += &corruption;
        case.outcome = Outcome::Skipped(reasons);
    } else {
        let (kind, text) = ("incomplete".to_owned(), corruption.trim_end().to_owned());
        case.outcome = Outcome::Error(Reason { kind, message: reasons, text });
    }
    for note in &subject.notes {
        let _ = writeln!(case.output, "{}", shown(note));
    }
    case
}

fn rule_case(subject: &Subject, rule: &Rule, found: &RuleVerdict) -> junit::Case {
    let mut case = junit::Case::passed(shown(&subject.path), format!("{} {}", rule.id, rule.statement));
    let findings: Vec<&Finding> = subject.findings.iter().filter(|finding| finding.rule == rule.id).collect();
    let text = findings_text(&findings, found.findings);
    match found.verdict {
        Verdict::Pass => {}
        Verdict::Warn | Verdict::Shown | Verdict::Known => case.output = text,
        Verdict::NotCovered | Verdict::Unsupported | Verdict::Inconclusive => {
            case.outcome = Outcome::Skipped(found.verdict.name().to_owned());
        }
        Verdict::Fail => {
            let message = findings.first().and_then(|finding| {
                Some(shown(&format!("{}: {}", finding.subject, finding.examples.first()?.text())))
            });
            let message = message.unwrap_or_else(|| rule.statement.to_owned());
            case.outcome = Outcome::Failed(Reason { kind: rule.id.to_owned(), message, text });
        }
    }
    if found.findings > 0 {
        let first = findings.first().and_then(|finding| finding.examples.first());
        let region = first.map_or(Region::Whole, |example| region(example.location));
        case.place = Some(place(&subject.path, region));
    }
    case
}

/// The findings of a rule as text.
fn findings_text(findings: &[&Finding], count: u64) -> String {
    let mut text = String::new();
    let mut line = |depth: usize, label: &str, value: &str| {
        if !value.is_empty() {
            // Writing to a string can't fail.
            let _ = writeln!(text, "{:depth$}{label}{}", "", shown(value));
        }
    };
    for finding in findings.iter().take(MAX_FINDINGS) {
        let times = if finding.count == 1 { "once".to_owned() } else { format!("{} times", finding.count) };
        line(0, "", &format!("{}: {times}", finding.subject));
        for example in &finding.examples {
            line(2, "", &format!("{}: {}", example.location, example.text()));
            line(4, "", &example.moment());
            line(4, "at: ", example.at());
            line(4, "expected: ", &example.expected);
            line(4, "found: ", &example.actual);
            line(4, "request: ", &example.request);
            line(4, "excerpt: ", &example.excerpt);
        }
        if let Some(definition) = &finding.definition {
            line(2, &format!("{definition}: "), definition.text.trim());
        }
        line(2, "known: ", finding.known.as_ref().map_or("", |known| &known.reason));
    }
    if let Some(first) = findings.first() {
        line(0, "to reproduce: ", &first.reproduce);
        line(0, "see: ", &first.url);
    }
    let listed: u64 = findings.iter().take(MAX_FINDINGS).map(|finding| finding.count).sum();
    if count > listed {
        line(0, "", &format!("… and {} more", count - listed));
    }
    text.truncate(text.trim_end().len());
    text
}

fn testee_cases(subject: &Subject, testee: &Testee) -> Vec<junit::Case> {
    let mut cases: Vec<junit::Case> = testee.cases.iter().map(testee_case).collect();
    let protocol = |name: &str, outcome| junit::Case { outcome, ..junit::Case::passed("protocol", name) };
    let remarks = testee.protocol_remarks.iter();
    let remarks: Vec<String> =
        remarks.map(|remark| format!("{} ({} times)", shown(&remark.message), remark.count)).collect();
    cases.push(match remarks.first() {
        None => junit::Case::passed("protocol", "no violations"),
        Some(first) => {
            let (kind, message) = ("protocol".to_owned(), first.clone());
            protocol("no violations", Outcome::Failed(Reason { kind, message, text: remarks.join("\n") }))
        }
    });
    if let Some(reason) = &testee.gave_up {
        let (kind, message) = (OutcomeKind::Failed.name().to_owned(), shown(reason));
        let text = format!("{}: {message}", shown(&subject.path));
        cases.push(protocol("run completes", Outcome::Error(Reason { kind, message, text })));
    }
    cases
}

fn testee_case(case: &Case) -> junit::Case {
    let outcome = match case.verdict {
        CaseVerdict::Pass => Outcome::Passed,
        CaseVerdict::Unsupported => Outcome::Skipped("not supported by the testee".to_owned()),
        CaseVerdict::NotRun => Outcome::Skipped("not run".to_owned()),
        // Known failures are reported as skipped.
        _ if case.known.is_some() => Outcome::Skipped("known".to_owned()),
        CaseVerdict::Fail => Outcome::Failed(reason(case)),
        CaseVerdict::Crashed | CaseVerdict::TimedOut => Outcome::Error(reason(case)),
    };
    junit::Case {
        outcome,
        errors: case.stderr.lines().map(|line| shown(line) + "\n").collect(),
        output: case.known.as_ref().map(|known| shown(&known.reason)).unwrap_or_default(),
        ..junit::Case::passed(format!("{}/{}", case.op, case.type_name), shown(&case.name))
    }
}

fn reason(case: &Case) -> Reason {
    let message = match case.verdict {
        CaseVerdict::Fail => format!("expected {}, got {}", shown(&case.expected), shown(&case.actual)),
        _ => shown(&case.message),
    };
    let mut text = shown(&case.description) + "\n";
    for (label, value) in [
        ("at: ", &case.path),
        ("expected: ", &case.expected),
        ("got: ", &case.actual),
        ("", &case.message),
        ("to reproduce: ", &case.reproduce),
    ] {
        if !value.is_empty() {
            // Writing to a string can't fail.
            let _ = writeln!(text, "{label}{}", shown(value));
        }
    }
    text.truncate(text.trim_end().len());
    Reason { kind: case.verdict.name().to_owned(), message, text }
}
