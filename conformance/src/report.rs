//! What came of a run: one value, from which everything is rendered that is said of it.
//!
//! ```text
//!  results of `check`    ──capture─┐
//!                                  ├──▶ Report ──▶ text, JSON, JUnit, SARIF, HTML, Markdown
//!  outcome of `test` ─────testee───┘
//! ```
//!
//! The JSON form is the value itself, so that nothing can be said elsewhere that programs don't get. Whatever
//! comes from the input stands in it as it is; each format escapes it in its own way.
//!
//! ```
//! use uavspec_conformance::check::check_capture;
//! use uavspec_conformance::definitions::Definitions;
//! use uavspec_conformance::report::{Action, CheckedCapture, Kind, OutcomeKind, Report, Settings, Subject};
//!
//! let definitions = Definitions::built_in();
//! let of = definitions.message_of_type("px4/ArmingCheckRequest");
//! let record = r#"{"timestamp": 7, "request_id": 30, "valid_registrations_mask": 1}"#;
//! let result = check_capture(record.as_bytes(), of, &definitions)?;
//! let checked = CheckedCapture { path: "requests.jsonl".to_owned(), result, notes: Vec::new(), elapsed: 0 };
//! let subject = Subject::from_capture(checked, &definitions, &Settings::default());
//! let command = "uavspec check requests.jsonl".to_owned();
//! let report = Report::new(Action::Check, command, &definitions, vec![subject], Vec::new(), Vec::new());
//! assert_eq!(report.outcome.kind, OutcomeKind::Conforms);
//! assert!(report.to_text(Kind::Markdown).contains("## `requests.jsonl`"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod capture;
mod html;
mod json;
mod junit;
mod kind;
mod markdown;
mod outcome;
pub(crate) mod rule_list;
mod sarif;
#[cfg(test)]
mod schema;
mod testee;
mod text;

use serde::Serialize;

pub use self::capture::{CheckedCapture, Settings};
pub use self::kind::Kind;
pub use self::outcome::{Outcome, OutcomeKind};
pub(crate) use self::text::subject as subject_text;
use crate::check::{Summary, Totals};
use crate::definitions::Definitions;
use crate::model::{Excuse, Extent, Level, Location, Reason, Rule, Status};
use crate::rules::RULES;

/// The version of the form; it rises when a member changes its meaning or goes.
const VERSION: u32 = 1;

/// What came of a run.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Report {
    /// The version of this form. It rises when a member changes its meaning or goes; new ones may come.
    pub version: u32,
    /// The version of uavspec.
    pub uavspec: String,
    /// What was done.
    pub action: Action,
    /// The command line, which gives the same report again.
    pub command: String,
    /// What was judged by: a path, or the definitions that the program carries along.
    pub definitions: String,
    /// What it comes to.
    #[serde(rename = "conclusion")]
    pub outcome: Outcome,
    /// Why the run as a whole fails, beside what was found: a rule that had to be exercised and wasn't, or an entry of a
    /// list of known failures that no longer holds true.
    pub reasons: Vec<Reason>,
    /// The rules that were applied, by id, with what came of them in all subjects.
    pub rules: Vec<RuleReport>,
    /// What was judged.
    pub subjects: Vec<Subject>,
    /// What couldn't be read.
    pub unreadable: Vec<Unreadable>,
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// Sources were judged.
    Check,
    /// A testee was asked.
    Test,
    /// A live server was asked.
    Probe,
}

/// A rule, and what came of it in all subjects.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RuleReport {
    /// The id, which is permanent.
    pub id: &'static str,
    /// How much the rule binds.
    pub level: Level,
    /// Whether it is beyond doubt: normative, disputed or advisory.
    pub status: String,
    /// How the specification contradicts itself, where the rule is disputed.
    pub dispute: Option<&'static str>,
    /// What has to hold.
    pub statement: &'static str,
    /// What lays it down.
    pub source: &'static str,
    /// What it is about.
    pub applies_to: &'static str,
    /// A page that says more.
    pub url: String,
    /// The worst that came of it in any subject.
    pub verdict: Verdict,
    /// How often there was something that it could judge.
    #[serde(rename = "exercised")]
    pub covered: u64,
    /// How often it was broken.
    pub findings: u64,
}

/// What came of a rule; in the order of how much each weighs where there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing was there that it could have judged. That is no pass.
    #[serde(rename = "not exercised")]
    NotCovered,
    /// The testee doesn't do what it is about. That is no failure, and no pass.
    Unsupported,
    /// Nothing breaks it.
    Pass,
    /// It is broken, or rather shown: it judges nothing.
    Shown,
    /// All that breaks it is known, and let stand.
    Known,
    /// It could not be judged to the end.
    Inconclusive,
    /// Something breaks it, and should be looked at.
    Warn,
    /// Something breaks it that must not.
    Fail,
}

/// Something that was judged: a file, or a testee.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Subject {
    /// The path of a file as it was given, or the name of a testee.
    pub path: String,
    /// What it is.
    #[serde(flatten)]
    pub about: About,
    /// How many messages it has, or for a testee, cases there are.
    pub records: u64,
    /// How many of them were judged: those that have a type and can be read as it, or that were answered.
    #[serde(rename = "judged")]
    pub checked: u64,
    /// From the first to the last timestamp, in µs.
    pub duration_us: u64,
    /// What it comes to.
    #[serde(rename = "conclusion")]
    pub outcome: Outcome,
    /// What came of each rule, by id.
    pub rules: Vec<RuleVerdict>,
    /// What breaks rules, by rule and subject.
    pub findings: Vec<Finding>,
    /// How many other findings there are; only a thousand different ones are kept of each rule.
    pub more_findings: u64,
    /// What can't be read, and where; the first of it.
    #[serde(rename = "damage")]
    pub corruption: Vec<Corruption>,
    /// How much more of that there is.
    #[serde(rename = "more_damage")]
    pub more_corruption: u64,
    /// How much of it could be read.
    pub extent: Extent,
    /// What happened while a server was probed, in order, that is no finding.
    pub notes: Vec<String>,
    /// How long judging took, in milliseconds; no part of what is written for programs, as it differs from run to
    /// run.
    #[serde(skip)]
    pub elapsed: u128,
}

/// What a subject is, and its summary.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum About {
    /// A capture.
    Capture(Summary),
    /// A codec or validator under test.
    Testee(Testee),
}

/// A codec or validator under test, and its answers.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Testee {
    /// The kind of the subject.
    pub kind: TesteeKind,
    /// What it calls its version; empty where it says none.
    pub version: String,
    /// How many cases came to what.
    pub counts: Counts,
    /// The same for each op with its form, and type.
    pub table: Vec<Row>,
    /// The cases; those that passed are counted only.
    #[serde(serialize_with = "testee::not_passed")]
    pub cases: Vec<Case>,
    /// What was against the protocol.
    #[serde(rename = "manners")]
    pub protocol_remarks: Vec<Remark>,
    /// How many other remarks there are on that.
    #[serde(rename = "more_manners")]
    pub more_protocol_remarks: u64,
    /// How often the process had to be started again.
    pub restarts: u32,
    /// Why the run ended early.
    pub gave_up: Option<String>,
}

/// The kind of a subject that is a testee.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum TesteeKind {
    /// A codec or validator under test.
    #[default]
    Testee,
}

/// How many cases came to what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Counts {
    /// Right answers.
    pub pass: u64,
    /// Wrong answers, crashes and hangs.
    pub fail: u64,
    /// Those that are known, and let stand.
    pub known: u64,
    /// What the testee doesn't do.
    pub unsupported: u64,
    /// What it wasn't asked.
    pub not_run: u64,
}

/// The counts of an op and a type.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Row {
    /// The op with its form, such as `decode-uorb`.
    pub op: String,
    /// The type, such as `px4/Event`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// What its cases came to.
    pub counts: Counts,
}

/// What came of a case.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Case {
    /// Its name, such as `decode-uorb/px4/Event/typical`.
    #[serde(rename = "case")]
    pub name: String,
    /// The op with its form.
    pub op: String,
    /// The type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// What is tried, in words.
    pub description: String,
    /// The id of the rule that the input breaks.
    pub rule: Option<String>,
    /// What came of it.
    pub verdict: CaseVerdict,
    /// Where in the answer it is wrong, as a JSON pointer; empty for the whole.
    pub path: String,
    /// What should be there.
    pub expected: String,
    /// What is there.
    pub actual: String,
    /// How the process ended, or how long was waited; empty where an answer came.
    pub message: String,
    /// What the process said last on standard error.
    pub stderr: String,
    /// Where the type is defined.
    pub definition: Option<Definition>,
    /// The command that asks this alone again.
    pub reproduce: String,
    /// Why it is let stand, where a list says so.
    pub known: Option<Known>,
}

/// What came of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum CaseVerdict {
    /// The answer was right.
    Pass,
    /// The answer was wrong.
    Fail,
    /// The testee doesn't do this. That is no failure, and no pass.
    Unsupported,
    /// The process ended over it.
    Crashed,
    /// No answer came in time.
    #[serde(rename = "timed out")]
    TimedOut,
    /// It was not asked: the run ended before, or the answer is absent from a file.
    #[serde(rename = "not run")]
    NotRun,
}

/// Something against the protocol.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Remark {
    /// What.
    pub message: String,
    /// How often.
    pub count: u64,
}

/// What came of a rule in a subject.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RuleVerdict {
    /// The id of the rule.
    pub id: &'static str,
    /// How much it binds.
    pub level: Level,
    /// What came of it.
    pub verdict: Verdict,
    /// How often there was something that it could judge.
    #[serde(rename = "exercised")]
    pub covered: u64,
    /// How often it was broken.
    pub findings: u64,
}

/// Equal findings: of one rule, in one topic or field.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Finding {
    /// The id of the rule.
    pub rule: &'static str,
    /// How much it binds.
    pub level: Level,
    /// Whether it is beyond doubt: normative, disputed or advisory.
    pub status: String,
    /// What has to hold.
    pub statement: &'static str,
    /// A page that says more of the rule.
    pub url: String,
    /// What it comes to: fail, warn, known or shown.
    pub verdict: Verdict,
    /// What breaks the rule: a topic, or a field of one.
    pub subject: String,
    /// How often.
    pub count: u64,
    /// The first of them.
    pub examples: Vec<Example>,
    /// Where the definition says what should be.
    pub definition: Option<Definition>,
    /// The command that finds this again.
    pub reproduce: String,
    /// Why it is let stand, where a list says so.
    pub known: Option<Known>,
}

/// A breach.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Example {
    /// Where in the file.
    #[serde(flatten)]
    pub location: Location,
    /// Where in the record: of JSON a pointer, as `/msg/events/2/id`, otherwise the path of a field, as `events[2].id`.
    /// Empty where it is about the whole record, or more than one.
    pub path: String,
    /// What the words are about, where the subject doesn't say it all; no part of what is written for programs, which
    /// have the path.
    #[serde(skip)]
    pub part: String,
    /// What is the matter, in words.
    pub message: String,
    /// What should have been; empty where that can't be said alone.
    pub expected: String,
    /// What was found in its place; may be empty.
    pub actual: String,
    /// The bytes or the text that were judged, shortened; may be empty.
    pub excerpt: String,
}

/// A line of a definition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Definition {
    /// The file.
    pub file: String,
    /// Which line, from 1.
    pub line: u64,
    /// What it says.
    pub text: String,
}

/// Why something that is wrong is let stand.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Known {
    /// Whether it always fails: `known`, or else `flaky`.
    pub kind: String,
    /// The reason.
    pub reason: String,
    /// A page on it.
    pub link: Option<String>,
    /// The last day that it is let stand, as `2027-06-30`.
    pub expires: Option<String>,
}

/// Something that can't be read.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Corruption {
    /// Where in the file.
    #[serde(flatten)]
    pub location: Location,
    /// What is the matter.
    pub message: String,
}

/// A file that couldn't be read.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Unreadable {
    /// Its path, as it was given.
    pub path: String,
    /// Why.
    pub message: String,
}

impl Report {
    /// Puts a report together.
    ///
    /// `reasons` not to conform are no findings, such as that a rule had to be exercised.
    pub fn new(
        action: Action,
        command: String,
        definitions: &Definitions,
        subjects: Vec<Subject>,
        unreadable: Vec<Unreadable>,
        reasons: Vec<Reason>,
    ) -> Self {
        let remarks = reasons.iter().map(Reason::to_string).collect();
        Self {
            version: VERSION,
            uavspec: env!("CARGO_PKG_VERSION").to_owned(),
            action,
            command,
            definitions: definitions.name.clone(),
            outcome: Outcome::for_run(action, &subjects, &unreadable, remarks),
            reasons,
            rules: rules(&subjects),
            subjects,
            unreadable,
        }
    }

    /// The same, where these entries of lists of known failures don't hold true any more; that weighs less than what
    /// fails.
    #[must_use]
    pub(crate) fn with_stale(mut self, entries: Vec<Reason>) -> Self {
        if entries.is_empty() {
            return self;
        }
        let mut remarks = vec![self.outcome.text.clone()];
        remarks.extend(entries.iter().map(Reason::to_string));
        self.reasons.extend(entries);
        if self.outcome.kind < OutcomeKind::Stale {
            let text = "A list of known failures no longer holds true";
            self.outcome = Outcome { remarks, ..Outcome::new(OutcomeKind::Stale, text) };
        }
        self
    }
}

impl From<&Excuse> for Known {
    fn from(excuse: &Excuse) -> Self {
        Self {
            kind: excuse.kind.name().to_owned(),
            reason: excuse.reason.clone(),
            link: excuse.link.clone(),
            expires: excuse.expires.map(|date| date.to_string()),
        }
    }
}

/// The rules of all subjects, each with the worst that came of it.
fn rules(subjects: &[Subject]) -> Vec<RuleReport> {
    let of = |rule: &&'static Rule| {
        let verdicts = subjects.iter().flat_map(|subject| &subject.rules).filter(|found| found.id == rule.id);
        let mut report = None;
        for found in verdicts {
            let report = report.get_or_insert_with(|| RuleReport::new(rule));
            report.verdict = report.verdict.max(found.verdict);
            report.covered += found.covered;
            report.findings += found.findings;
        }
        report
    };
    RULES.iter().filter_map(of).collect()
}

impl RuleReport {
    fn new(rule: &Rule) -> Self {
        Self {
            id: rule.id,
            level: rule.level,
            status: rule.status.to_string(),
            dispute: match rule.status {
                Status::Disputed(how) => Some(how),
                Status::Normative | Status::Advisory => None,
            },
            statement: rule.statement,
            source: rule.source,
            applies_to: rule.applies_to,
            url: uavspec_codegen::report::rule_url(rule.id),
            verdict: Verdict::NotCovered,
            covered: 0,
            findings: 0,
        }
    }
}

impl Verdict {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotCovered => "not exercised",
            Self::Unsupported => "unsupported",
            Self::Pass => "pass",
            Self::Shown => "shown",
            Self::Known => "known",
            Self::Inconclusive => "inconclusive",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }
}

impl CaseVerdict {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Unsupported => "unsupported",
            Self::Crashed => "crashed",
            Self::TimedOut => "timed out",
            Self::NotRun => "not run",
        }
    }

    /// Whether it counts against the testee.
    pub const fn is_failure(self) -> bool {
        matches!(self, Self::Fail | Self::Crashed | Self::TimedOut)
    }
}

impl Subject {
    /// The counts that all captures have in common.
    fn totals(&self) -> Totals {
        Totals { records: self.records, duration_us: self.duration_us }
    }

    /// True if it is a testee, and no capture.
    fn is_testee(&self) -> bool {
        matches!(self.about, About::Testee(_))
    }

    /// How many of its rules came to a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rules.iter().filter(|rule| rule.verdict == verdict).count()
    }

    /// How many places of damage there are.
    pub(crate) fn corrupt_count(&self) -> u64 {
        self.corruption.len() as u64 + self.more_corruption
    }
}

impl Report {
    /// How many rules came to a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rules.iter().filter(|rule| rule.verdict == verdict).count()
    }
}

impl Example {
    /// Where in the record, unless the words begin with that.
    pub(crate) fn at(&self) -> &str {
        if self.path == self.part { "" } else { &self.path }
    }

    /// What is the matter, and with what part.
    pub(crate) fn text(&self) -> String {
        if self.part.is_empty() { self.message.clone() } else { format!("{}: {}", self.part, self.message) }
    }
}

impl Definition {
    fn new(line: crate::definitions::Line<'_>) -> Self {
        Self { file: line.file.to_owned(), line: line.number as u64, text: line.text.to_owned() }
    }
}

impl std::fmt::Display for Definition {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}:{}", self.file, self.line)
    }
}
