//! The result of checking a capture, as a subject of a report.

use crate::check::CaptureResult;
use crate::definitions::Definitions;
use crate::model::{self, Findings, Group, Rule};
use crate::rules::{RULES, px4};

use super::outcome::CaptureCounts;
use super::{
    About, Corruption, Definition, Example, Finding, Known, Outcome, OutcomeKind, RuleVerdict, Subject,
    Verdict,
};

/// A capture that was checked.
#[derive(Debug)]
pub struct CheckedCapture {
    /// The path as the user gave it.
    pub path: String,
    /// The result.
    pub result: CaptureResult,
    /// Notable events during a probe, in order. They are not findings.
    pub notes: Vec<String>,
    /// The duration of the check, in milliseconds.
    pub elapsed: u128,
}

/// The run settings that affect reports.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// True if formats that differ from the definitions count as violations.
    pub are_formats_strict: bool,
    /// The arguments of `check` that reproduce the findings, without the files.
    pub arguments: Vec<String>,
    /// The command that reproduces the findings, if it isn't `check`.
    pub command: Option<String>,
}

impl Settings {
    /// The command that checks a capture again.
    fn command(&self, path: &str) -> String {
        if let Some(command) = &self.command {
            return command.clone();
        }
        let words = ["uavspec", "check"].into_iter().chain(self.arguments.iter().map(String::as_str));
        // A path that starts with a dash looks like an option. `-` alone denotes standard input.
        let is_like_option = path.starts_with('-') && path != "-";
        let path = if is_like_option { format!("./{path}") } else { path.to_owned() };
        crate::text::command_line(words.chain([path.as_str()]))
    }

    /// The verdict of a rule.
    fn verdict(&self, findings: &Findings, rule: &'static Rule) -> Verdict {
        match findings.verdict(rule) {
            model::Verdict::Shown if self.are_formats_strict && rule.id == px4::FMT_01.rule.id => {
                Verdict::Fail
            }
            other => other.into(),
        }
    }
}

impl From<model::Verdict> for Verdict {
    fn from(verdict: model::Verdict) -> Self {
        match verdict {
            model::Verdict::Pass => Self::Pass,
            model::Verdict::Warn => Self::Warn,
            model::Verdict::Fail => Self::Fail,
            model::Verdict::Shown => Self::Shown,
            model::Verdict::Known => Self::Known,
            model::Verdict::NotCovered => Self::NotCovered,
        }
    }
}

impl Subject {
    /// Creates the subject of a capture.
    pub fn from_capture(checked: CheckedCapture, definitions: &Definitions, settings: &Settings) -> Self {
        let CheckedCapture { path, result, notes, elapsed } = checked;
        let findings = &result.findings;
        // Rules for other kinds of captures aren't listed.
        let is_session = result.summary.describe().is_session();
        let rules: Vec<RuleVerdict> = RULES
            .iter()
            .filter(|rule| rule.is_on_flockwave() == is_session)
            .map(|rule| rule_verdict(rule, findings, settings.verdict(findings, rule)))
            .collect();
        let command = settings.command(&path);
        let finding =
            |group: &Group| finding(group, settings.verdict(findings, group.rule), &command, definitions);
        let corruption = result.corruption.iter();
        let mut subject = Self {
            path,
            about: About::Capture(result.summary),
            records: result.records,
            checked: result.checked,
            duration_us: result.duration,
            outcome: Outcome::new(OutcomeKind::Nothing, String::new()),
            findings: findings.groups().map(finding).collect(),
            more_findings: RULES.iter().map(|rule| findings.dropped(rule)).sum(),
            rules,
            corruption: corruption
                .map(|(location, text)| Corruption { location: *location, message: text.clone() })
                .collect(),
            more_corruption: result.more_corruption,
            extent: result.extent,
            notes,
            elapsed,
        };
        subject.set_outcome();
        subject
    }

    /// Sets the outcome of a capture from its verdicts.
    pub(crate) fn set_outcome(&mut self) {
        let counts = CaptureCounts {
            checked: self.checked,
            failed: self.count(Verdict::Fail),
            warned: self.count(Verdict::Warn),
            known: self.findings.iter().filter(|finding| finding.known.is_some()).count(),
            corrupt: self.corrupt_count(),
        };
        let noun = match &self.about {
            About::Capture(summary) => summary.describe().noun(),
            About::Testee(_) => "file",
        };
        self.outcome = Outcome::for_capture(counts, self.extent, noun);
    }
}

fn rule_verdict(rule: &'static Rule, findings: &Findings, verdict: Verdict) -> RuleVerdict {
    let grouped: u64 = findings.groups_of(rule).map(|group| group.count).sum();
    RuleVerdict {
        id: rule.id,
        level: rule.level,
        verdict,
        covered: findings.covered(rule),
        findings: grouped + findings.dropped(rule),
    }
}

fn finding(group: &Group, verdict: Verdict, command: &str, definitions: &Definitions) -> Finding {
    let Group { rule, subject, count, examples, definition, known, .. } = group;
    let example = |(location, detail): &(_, crate::model::Detail)| Example {
        location: *location,
        path: detail.path.clone(),
        part: detail.part.clone(),
        message: detail.message.clone(),
        expected: detail.expected.clone(),
        actual: detail.actual.clone(),
        excerpt: detail.excerpt.clone(),
    };
    Finding {
        rule: rule.id,
        level: rule.level,
        status: rule.status.to_string(),
        statement: rule.statement,
        url: uavspec_codegen::report::rule_url(rule.id),
        verdict: if known.is_some() { Verdict::Known } else { verdict },
        subject: subject.clone(),
        count: *count,
        examples: examples.iter().map(example).collect(),
        definition: definition.map(|span| Definition::new(definitions.line(span))),
        reproduce: command.to_owned(),
        known: known.as_ref().map(Known::from),
    }
}
