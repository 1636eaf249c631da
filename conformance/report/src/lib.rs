//! The report of a run: a single value from which all formats are rendered.
//!
//! ```text
//!  results of `check`    ──capture─┐
//!                                  ├──▶ Report ──▶ text, JSON, JUnit, SARIF, Code Quality, HTML, Markdown
//!  outcome of `test` ─────testee───┘
//! ```
//!
//! The JSON format serializes this value directly, so it contains everything that the other formats show. Text from the
//! input is stored unchanged; each format escapes it.
//!
//! ```
//! use std::time::Duration;
//!
//! use uavspec_check::check_capture;
//! use uavspec_rules::definitions::Definitions;
//! use uavspec_report::{Action, CheckedCapture, Kind, OutcomeKind, Report, Settings, Subject};
//!
//! let definitions = Definitions::built_in();
//! let message_type = definitions.message_of_type("px4/ArmingCheckRequest");
//! let record = r#"{"timestamp": 7, "request_id": 30, "valid_registrations_mask": 1}"#;
//! let result = check_capture(record.as_bytes(), message_type, &definitions)?;
//! let checked = CheckedCapture::new("requests.jsonl".to_owned(), result, Duration::ZERO);
//! let subject = Subject::from_capture(checked, &definitions, &Settings::default());
//! let command = "uavspec check requests.jsonl".to_owned();
//! let report = Report::new(Action::Check, command, &definitions.name, vec![subject], Vec::new(), Vec::new());
//! assert_eq!(report.outcome.kind, OutcomeKind::Conforms);
//! assert!(report.to_text(Kind::Markdown).contains("## `requests.jsonl`"));
//! # Ok::<(), std::io::Error>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod explain;

mod by_rule;
mod capture;
mod codequality;
mod entries;
mod html;
mod json;
mod junit;
mod kind;
mod markdown;
mod origin;
mod outcome;
pub mod rule_list;
mod sarif;
#[cfg(test)]
mod schema;
mod short;
mod spool;
mod stream;
mod testee;
mod text;
pub mod timeline;
mod totals;

use serde::Serialize;
use uavspec_check::{Coverage, Describe, Line, Summary};
pub use uavspec_model::Verdict;
use uavspec_model::text::shown;
use uavspec_model::{Excuse, Extent, Level, Location, Reason, Rule};
use uavspec_probe::RequestType;

pub use self::capture::{CheckedCapture, Settings};
pub use self::kind::{Kind, TableFormat};
pub use self::origin::Origin;
pub use self::outcome::{Outcome, OutcomeKind};
pub use self::stream::Stream;
pub use self::testee::{Case, CaseVerdict, Counts, Remark, Row, Testee, TesteeKind};
pub use self::text::{end as end_text, subject as subject_text};
pub use self::totals::Totals;

/// The version of the JSON format.
const VERSION: u32 = 1;

/// The report of a run.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// The version of this format. The version increases if a member is removed or changes meaning.
    pub version: u32,
    /// The version of uavspec.
    pub uavspec: String,
    /// The command that was run.
    pub action: Action,
    /// The command line that reproduces the report.
    pub command: String,
    /// The path of the definitions, or the name of the built-in definitions.
    pub definitions: String,
    /// The outcome of the run.
    pub outcome: Outcome,
    /// Reasons for failure other than findings: uncovered required rules, and outdated entries of baselines.
    pub reasons: Vec<Reason>,
    /// The rules that were checked, sorted by id, with their results across all subjects.
    pub rules: Vec<RuleReport>,
    /// The captures and testees that were checked.
    pub subjects: Vec<Subject>,
    /// The files that couldn't be opened, and a server that failed.
    pub unreadable: Vec<Unreadable>,
    /// The files in folders that aren't captures. They don't affect the outcome.
    pub not_checked: Vec<Unreadable>,
    /// The results across all subjects.
    #[serde(skip)]
    totals: Totals,
}

/// A command that writes reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// Captures were checked.
    #[default]
    Check,
    /// A testee was tested.
    Test,
    /// A live server was probed.
    Probe,
}

/// A rule with its results across all subjects.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct RuleReport {
    /// The permanent id.
    pub id: &'static str,
    /// The level of the rule.
    pub level: Level,
    /// The status: normative, disputed or advisory.
    pub status: String,
    /// The contradiction in the specification, if the rule is disputed.
    pub dispute: Option<&'static str>,
    /// The requirement.
    pub statement: &'static str,
    /// The source of the requirement.
    pub source: &'static str,
    /// The kind of data that the rule applies to.
    pub applies_to: &'static str,
    /// The URL of the rule's page; absent if the documentation site is not published.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub url: String,
    /// The worst verdict across all subjects.
    pub verdict: Verdict,
    /// The number of times that the rule was checked.
    pub covered: u64,
    /// The number of findings.
    pub findings: u64,
}

/// A capture, a server or a testee that was checked.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Subject {
    /// The path of a file as given, the URL of a server, or the name of a testee.
    pub path: String,
    /// The kind of the subject, and its summary.
    #[serde(flatten)]
    pub about: About,
    /// The number of messages; for a testee, the number of cases.
    pub records: u64,
    /// The number of messages that could be decoded as their type; for a testee, the number of cases with a result.
    pub checked: u64,
    /// The time from the first to the last timestamp, in µs.
    pub duration_us: u64,
    /// The outcome for this subject.
    pub outcome: Outcome,
    /// The verdict of each rule, sorted by id.
    pub rules: Vec<RuleVerdict>,
    /// The findings, grouped by rule and by topic or field.
    pub findings: Vec<Finding>,
    /// The number of findings that are only counted, because there are more than a thousand groups of a rule or ten
    /// thousand groups in total.
    pub more_findings: u64,
    /// The first corrupt or unreadable parts.
    pub corruption: Vec<Corruption>,
    /// The number of further corrupt or unreadable parts.
    pub more_corruption: u64,
    /// The extent to which the input could be read.
    pub extent: Extent,
    /// The topics or types, and the extent to which they were checked.
    pub coverage: Coverage,
    /// The event metadata that explains the events of a capture, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event_metadata: Option<String>,
    /// The reasons why the subject wasn't read or checked completely.
    pub incomplete: Vec<String>,
    /// The reasons that are known apart from the extent and the coverage. They are part of `incomplete`.
    #[serde(skip)]
    pub cut_short: Vec<String>,
    /// Notable events during a probe, in order. These notes are not findings.
    pub notes: Vec<String>,
    /// The request types of the definitions, if this is a server that was probed.
    #[serde(rename = "request_types")]
    pub requests: Vec<RequestType>,
    /// True if the capture is a file, so that its lines can be looked up. False for a live server without a recording.
    #[serde(skip)]
    pub is_readable_again: bool,
    /// The start in UTC, in µs since 1970, if it is known.
    #[serde(skip)]
    pub start_utc: Option<u64>,
    /// The duration of the check, in milliseconds. The JSON report omits the duration because it differs between runs.
    #[serde(skip)]
    pub elapsed: u128,
}

/// The kind of a subject, with its summary.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum About {
    /// A capture.
    Capture(Summary),
    /// A codec or validator under test.
    Testee(Testee),
}

/// The result of a rule for a subject.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct RuleVerdict {
    /// The id of the rule.
    pub id: &'static str,
    /// The level of the rule.
    pub level: Level,
    /// The verdict.
    pub verdict: Verdict,
    /// The number of times that the rule was checked.
    pub covered: u64,
    /// The number of findings.
    pub findings: u64,
}

/// The findings of one rule in one topic or field.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Finding {
    /// The id of the rule.
    pub rule: &'static str,
    /// The level of the rule.
    pub level: Level,
    /// The status of the rule: normative, disputed or advisory.
    pub status: String,
    /// The requirement.
    pub statement: &'static str,
    /// The URL of the rule's page; absent if the documentation site is not published.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub url: String,
    /// The verdict: fail, warning, known or info.
    pub verdict: Verdict,
    /// The topic or field that violates the rule, with its namespace, or with its instance in a log with several.
    pub subject: String,
    /// The number of findings in this group.
    pub count: u64,
    /// The first findings.
    pub examples: Vec<Example>,
    /// The definition line that the rule refers to.
    pub definition: Option<Definition>,
    /// The URL of the page of the specification.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specification: Option<String>,
    /// The command that reproduces the finding.
    pub reproduce: String,
    /// The matching entry of a baseline.
    pub known: Option<Excuse>,
}

/// A single finding.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Example {
    /// The location in the file.
    #[serde(flatten)]
    pub location: Location,
    /// The location in the record: a pointer such as `/msg/events/2/id` in JSON, or a field path such as `events[2].id`
    /// in other formats. The location is empty if the finding concerns the whole record or several records.
    pub path: String,
    /// The part of the subject that the message refers to; may be empty. The JSON report contains the path instead.
    #[serde(skip)]
    pub part: String,
    /// The description.
    pub message: String,
    /// The expected value; may be empty.
    pub expected: String,
    /// The actual value; may be empty.
    pub actual: String,
    /// The start of the bytes or text that were checked; may be empty.
    pub excerpt: String,
    /// The time of the record since the start of the capture, in seconds, if it is known.
    pub time_s: Option<f64>,
    /// The time of the record in UTC, in µs since 1970, if it is known.
    #[serde(skip)]
    pub utc_us: Option<u64>,
    /// The time of the record in UTC, if it is known.
    pub utc: Option<String>,
    /// The log time of the record in nanoseconds, if it is in a bag.
    pub log_time_ns: Option<u64>,
    /// The sequence number that the bag states for the record.
    pub sequence: Option<u32>,
    /// The connection of the record; empty if the capture isn't a session.
    pub connection: String,
    /// The request to which the record belongs, shortened; may be empty.
    pub request: String,
}

/// A line of a definition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Definition {
    /// The file.
    pub file: String,
    /// The line number, from 1.
    pub line: u64,
    /// The text of the line.
    pub text: String,
}

/// A corrupt or unreadable part of a file.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Corruption {
    /// The location in the file.
    #[serde(flatten)]
    pub location: Location,
    /// The description.
    pub message: String,
}

/// A file that wasn't read.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Unreadable {
    /// The path as given.
    pub path: String,
    /// The reason.
    pub message: String,
}

impl Report {
    /// Creates a report. `reasons` contains the reasons for failure other than findings.
    pub fn new(
        action: Action,
        command: String,
        definitions: &str,
        subjects: Vec<Subject>,
        unreadable: Vec<Unreadable>,
        reasons: Vec<Reason>,
    ) -> Self {
        let totals = Totals::of(&subjects);
        Self { subjects, ..Self::of_totals(action, command, definitions, totals, unreadable, reasons) }
    }

    /// Creates the report of a run, if only the totals of its subjects are available.
    pub fn of_totals(
        action: Action,
        command: String,
        definitions: &str,
        totals: Totals,
        unreadable: Vec<Unreadable>,
        reasons: Vec<Reason>,
    ) -> Self {
        let remarks = reasons.iter().map(Reason::to_string).collect();
        Self {
            version: VERSION,
            uavspec: env!("CARGO_PKG_VERSION").to_owned(),
            action,
            command,
            definitions: definitions.to_owned(),
            outcome: Outcome::for_run(action, &totals, &unreadable, remarks),
            reasons,
            rules: totals.rules.values().cloned().collect(),
            subjects: Vec::new(),
            unreadable,
            not_checked: Vec::new(),
            totals,
        }
    }

    /// Adds the files in folders that aren't captures.
    #[must_use]
    pub fn with_not_checked(self, not_checked: Vec<Unreadable>) -> Self {
        Self { not_checked, ..self }
    }

    /// Changes the outcome to state that an earlier run has checked all captures.
    #[must_use]
    pub fn with_nothing_new(self) -> Self {
        let text = "No new captures: an earlier run has checked all of them";
        Self { outcome: Outcome::new(OutcomeKind::Conforms, text), ..self }
    }

    /// Reports outdated entries of baselines. An outdated entry doesn't override a more severe outcome.
    #[must_use]
    pub fn with_stale(mut self, entries: Vec<Reason>) -> Self {
        if entries.is_empty() {
            return self;
        }
        let listed: Vec<String> = entries.iter().map(Reason::to_string).collect();
        self.reasons.extend(entries);
        if self.outcome.kind < OutcomeKind::Stale || self.outcome.is_success() {
            let text = "A baseline is out of date";
            let outcome = Outcome::new(OutcomeKind::Stale, text);
            self.outcome = Outcome { remarks: vec![std::mem::take(&mut self.outcome.text)], ..outcome };
        }
        self.outcome.remarks.extend(listed);
        self
    }
}

impl RuleReport {
    fn new(rule: &Rule) -> Self {
        Self {
            id: rule.id,
            level: rule.level,
            status: rule.status.to_string(),
            dispute: rule_list::dispute(rule),
            statement: rule.statement,
            source: rule.source,
            applies_to: rule.applies_to,
            url: uavspec_lint::report::rule_url(rule.id),
            verdict: Verdict::NotCovered,
            covered: 0,
            findings: 0,
        }
    }
}

impl Subject {
    /// The counts that every kind of capture has.
    fn totals(&self) -> uavspec_check::Totals {
        uavspec_check::Totals { records: self.records, duration_us: self.duration_us }
    }

    /// True if the subject is a testee.
    fn is_testee(&self) -> bool {
        matches!(self.about, About::Testee(_))
    }

    /// The coverage, as lines for people.
    fn coverage_lines(&self) -> Vec<Line> {
        self.coverage.lines(if self.is_testee() { "case" } else { "record" })
    }

    /// The summary of a capture, as lines for people.
    fn summary_lines(&self, summary: &dyn Describe) -> Vec<Line> {
        let text = |metadata: &String| format!("explained by {}", shown(metadata));
        let events = self.event_metadata.as_ref().map(|metadata| Line::new("events", text(metadata)));
        summary.lines().into_iter().chain(events).collect()
    }

    /// The number of rules with this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rules.iter().filter(|rule| rule.verdict == verdict).count()
    }

    /// The numbers of violated rules of level MUST and SHOULD. Rules whose violations are all known don't count.
    pub fn violated(&self) -> [u64; 2] {
        [Level::Must, Level::Should].map(|level| {
            self.rules.iter().filter(|rule| rule.level == level && totals::is_violated(rule)).count() as u64
        })
    }

    /// The number of corrupt or unreadable parts.
    pub fn corrupt_count(&self) -> u64 {
        self.corruption.len() as u64 + self.more_corruption
    }
}

impl Example {
    /// The location in the record. Empty if [`Self::text`] already starts with this location.
    pub(crate) fn at(&self) -> &str {
        if self.path == self.part { "" } else { &self.path }
    }

    /// The time, the connection and the log time, such as `after 4.592 s (2026-11-23T02:32:41.593Z) on tcp#13` or `after
    /// 4.592 s, log time 1790000004.592000000, sequence 7`; may be empty.
    pub fn moment(&self) -> String {
        let after = self.time_s.map(|seconds| format!("after {seconds:.3} s"));
        let utc = self.utc.as_ref().map(|utc| format!("({utc})"));
        let connection = (!self.connection.is_empty()).then(|| format!("on {}", shown(&self.connection)));
        let parts: Vec<String> = [after, utc, connection].into_iter().flatten().collect();
        let log_time = self.log_time_ns.map(|time| {
            let (seconds, nanoseconds) = (time / 1_000_000_000, time % 1_000_000_000);
            format!("log time {seconds}.{nanoseconds:09}")
        });
        let sequence = self.sequence.map(|sequence| format!("sequence {sequence}"));
        let moment = Some(parts.join(" ")).filter(|text| !text.is_empty());
        [moment, log_time, sequence].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// The message, preceded by the part of the subject that it refers to.
    pub(crate) fn text(&self) -> String {
        if self.part.is_empty() { self.message.clone() } else { format!("{}: {}", self.part, self.message) }
    }
}

impl Definition {
    fn new(line: uavspec_rules::definitions::Line<'_>) -> Self {
        Self { file: line.file.to_owned(), line: line.number as u64, text: line.text.to_owned() }
    }
}

impl std::fmt::Display for Definition {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}:{}", shown(&self.file), self.line)
    }
}
