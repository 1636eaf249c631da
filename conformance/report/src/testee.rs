//! The result of testing a testee, as a subject of a report.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Serialize, Serializer};
use uavspec_check::{Coverage, Share, Unit, names};
use uavspec_model::text::{plural, shown};
use uavspec_model::{Excuse, Extent};
pub use uavspec_probe::testee::outcome::Counts;
use uavspec_probe::testee::{case, outcome};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::rule;

use super::{About, Definition, Outcome, RuleVerdict, Subject, Verdict};

/// A codec or validator under test, with its results.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Testee {
    /// The kind of the subject.
    pub kind: TesteeKind,
    /// The version that the testee reports; empty if unknown.
    pub version: String,
    /// The number of cases with each result.
    pub counts: Counts,
    /// The counts for each operation and type.
    pub table: Vec<Row>,
    /// The cases that did not pass.
    #[serde(serialize_with = "not_passed")]
    pub cases: Vec<Case>,
    /// The violations of the test protocol.
    pub protocol_remarks: Vec<Remark>,
    /// The number of further protocol violations.
    pub more_protocol_remarks: u64,
    /// The number of restarts.
    pub restarts: u32,
    /// The reason why the run ended early, if it did.
    pub gave_up: Option<String>,
}

/// The kind of a subject that is a testee.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TesteeKind {
    /// A codec or validator under test.
    #[default]
    Testee,
}

/// The counts for one operation and type.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Row {
    /// The operation and format, such as `decode-uorb`.
    pub op: String,
    /// The type, such as `px4/Event`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The number of cases with each result.
    pub counts: Counts,
}

/// A case with its result.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct Case {
    /// The name, such as `decode-uorb/px4/Event/typical`.
    #[serde(rename = "case")]
    pub name: String,
    /// The operation and format.
    pub op: String,
    /// The type.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The purpose of the case.
    pub description: String,
    /// The id of the rule that the input violates.
    pub rule: Option<String>,
    /// The result.
    pub verdict: CaseVerdict,
    /// The location of the error in the response, as a JSON pointer; empty for the whole response.
    pub path: String,
    /// The expected value.
    pub expected: String,
    /// The actual value.
    pub actual: String,
    /// A description of the crash or timeout; empty if there was a response.
    pub message: String,
    /// The last lines that the process wrote to standard error.
    pub stderr: String,
    /// The definition of the type.
    pub definition: Option<Definition>,
    /// The command that runs only this case.
    pub reproduce: String,
    /// The matching entry of a baseline.
    pub known: Option<Excuse>,
}

/// The result of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CaseVerdict {
    /// The response was correct.
    #[default]
    Pass,
    /// The response was wrong.
    Fail,
    /// The testee doesn't support this. This result is neither a failure nor a pass.
    Unsupported,
    /// The process ended.
    Crashed,
    /// There was no response in time.
    #[serde(rename = "timed out")]
    TimedOut,
    /// The case was not run: the run ended early, or the file has no response.
    #[serde(rename = "not run")]
    NotRun,
}

/// A violation of the test protocol.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Remark {
    /// The description.
    pub message: String,
    /// The number of occurrences.
    pub count: u64,
}

impl CaseVerdict {
    /// The name.
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

    /// True if the case counts as failed.
    pub const fn is_failure(self) -> bool {
        matches!(self, Self::Fail | Self::Crashed | Self::TimedOut)
    }
}

impl Subject {
    /// Creates the subject of a testee. `rerun_command` returns the command that runs one case.
    pub fn from_testee(
        run: &outcome::Outcome<'_>,
        definitions: &Definitions,
        rerun_command: &dyn Fn(&str) -> String,
    ) -> Self {
        let verdicts = run.verdicts.iter();
        let cases: Vec<Case> =
            verdicts.map(|(case, verdict)| case_report(case, verdict, definitions, rerun_command)).collect();
        let counts = run.counts();
        let protocol_remarks = &run.protocol_remarks;
        let violations = protocol_remarks.remarks.len() + protocol_remarks.more;
        let gave_up = run.gave_up.clone();
        let outcome = Outcome::for_testee(counts, violations, gave_up.as_deref());
        let (name, version) = match &run.hello {
            Some(hello) => (hello.name.clone(), hello.version.clone()),
            None => ("testee".to_owned(), String::new()),
        };
        let rules = rules(&cases);
        let remark =
            |(message, count): &(String, usize)| Remark { message: message.clone(), count: *count as u64 };
        let row = |((op, type_name), counts): ((String, &str), Counts)| Row {
            op,
            type_name: type_name.to_owned(),
            counts,
        };
        let table: Vec<Row> = run.table().into_iter().map(row).collect();
        let coverage = coverage(&table, counts);
        let testee = Testee {
            kind: TesteeKind::Testee,
            version,
            counts,
            table,
            cases,
            protocol_remarks: protocol_remarks.remarks.iter().map(remark).collect(),
            more_protocol_remarks: protocol_remarks.more as u64,
            restarts: run.restarts,
            gave_up,
        };
        Self {
            path: name,
            about: About::Testee(testee),
            records: run.verdicts.len() as u64,
            checked: counts.checked(),
            duration_us: 0,
            outcome,
            rules,
            findings: Vec::new(),
            more_findings: 0,
            corruption: Vec::new(),
            more_corruption: 0,
            extent: Extent::Whole,
            coverage,
            event_metadata: None,
            incomplete: Vec::new(),
            cut_short: Vec::new(),
            notes: Vec::new(),
            requests: Vec::new(),
            is_readable_again: true,
            start_utc: None,
            elapsed: 0,
        }
    }
}

impl Testee {
    /// The rows that have cases which the testee supports.
    pub(super) fn supported(&self) -> impl Iterator<Item = &Row> {
        self.table.iter().filter(|row| row.is_supported())
    }

    /// Lines such as `140 types: px4/ActuatorTest, px4/Airspeed and 138 more`. The first line lists the types without
    /// any supported operation. The lines for individual operations don't repeat them.
    pub(super) fn unsupported_lines(&self) -> Vec<String> {
        let supported: BTreeSet<&str> = self.supported().map(|row| &*row.type_name).collect();
        let mut by_op: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for row in self.table.iter().filter(|row| !row.is_supported()) {
            let op = if supported.contains(&*row.type_name) { &*row.op } else { "" };
            by_op.entry(op).or_default().insert(&row.type_name);
        }
        let line = |(op, types): (&str, BTreeSet<&str>)| {
            let number = plural(types.len(), "type");
            let of = if op.is_empty() { String::new() } else { format!("{} of ", shown(op)) };
            format!("{of}{number}: {}", names(types.into_iter()))
        };
        by_op.into_iter().map(line).collect()
    }
}

impl Row {
    fn is_supported(&self) -> bool {
        self.counts.checked() + self.counts.not_run > 0
    }
}

/// The coverage of a testee: the types with at least one checked case, and the checked cases.
fn coverage(table: &[Row], counts: Counts) -> Coverage {
    let mut types: BTreeMap<&str, bool> = BTreeMap::new();
    for row in table {
        *types.entry(&row.type_name).or_default() |= row.counts.checked() > 0;
    }
    let checked = types.values().filter(|is_checked| **is_checked).count();
    Coverage {
        unit: Unit::Type,
        units: Share::of(checked as u64, types.len() as u64),
        records: Share::of(counts.checked(), counts.all()),
        ..Coverage::default()
    }
}

fn case_report(
    requested: &case::Case,
    verdict: &outcome::Verdict,
    definitions: &Definitions,
    rerun_command: &dyn Fn(&str) -> String,
) -> Case {
    let name = requested.name();
    let span =
        definitions.message_of_type(&requested.type_name).map(|id| definitions.schema.message(id).span);
    let (verdict, known) = match verdict {
        outcome::Verdict::Known { failure, excuse } => (&**failure, Some(excuse.clone())),
        other => (other, None),
    };
    let mut found = Case {
        op: requested.action(),
        type_name: requested.type_name.clone(),
        description: requested.description.clone(),
        rule: requested.rule.clone(),
        definition: span.map(|span| Definition::new(definitions.line(span))),
        reproduce: rerun_command(&name),
        known,
        name,
        ..Case::default()
    };
    found.verdict = match verdict {
        outcome::Verdict::Pass => CaseVerdict::Pass,
        outcome::Verdict::Unsupported => CaseVerdict::Unsupported,
        // The verdict within `Known` is never `Known`.
        outcome::Verdict::NotRun | outcome::Verdict::Known { .. } => CaseVerdict::NotRun,
        outcome::Verdict::Fail(difference) => {
            found.path.clone_from(&difference.path);
            found.expected.clone_from(&difference.expected);
            found.actual.clone_from(&difference.actual);
            CaseVerdict::Fail
        }
        outcome::Verdict::Crashed { how, stderr } => {
            found.message.clone_from(how);
            found.stderr.clone_from(stderr);
            CaseVerdict::Crashed
        }
        outcome::Verdict::TimedOut { after, stderr } => {
            found.message = format!("no response within {} s", after.as_secs_f32());
            found.stderr.clone_from(stderr);
            CaseVerdict::TimedOut
        }
    };
    found
}

/// The verdict of each rule that the input of at least one case violates. A rule passes if the testee rejects all
/// inputs that violate it.
fn rules(cases: &[Case]) -> Vec<RuleVerdict> {
    let mut rules: BTreeMap<&str, RuleVerdict> = BTreeMap::new();
    for case in cases {
        let Some(rule) = case.rule.as_deref().and_then(rule) else { continue };
        let (id, level) = (rule.id, rule.level);
        let found = rules.entry(rule.id).or_insert_with(|| RuleVerdict {
            id,
            level,
            verdict: Verdict::Unsupported,
            covered: 0,
            findings: 0,
        });
        let verdict = match case.verdict {
            _ if case.known.is_some() => Verdict::Known,
            CaseVerdict::Pass => Verdict::Pass,
            CaseVerdict::Unsupported => Verdict::Unsupported,
            CaseVerdict::NotRun => Verdict::Inconclusive,
            CaseVerdict::Fail | CaseVerdict::Crashed | CaseVerdict::TimedOut => Verdict::Fail,
        };
        found.verdict = found.verdict.max(verdict);
        found.covered += u64::from(matches!(verdict, Verdict::Pass | Verdict::Fail | Verdict::Known));
        found.findings += u64::from(verdict == Verdict::Fail);
    }
    rules.into_values().collect()
}

/// Serializes the cases that didn't pass. The other cases, of which there are thousands, are only counted.
pub(super) fn not_passed<S: Serializer>(cases: &[Case], serializer: S) -> Result<S::Ok, S::Error> {
    let others: Vec<&Case> = cases.iter().filter(|case| case.verdict != CaseVerdict::Pass).collect();
    others.serialize(serializer)
}
