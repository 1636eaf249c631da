//! The result of testing a testee, as a subject of a report.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Serialize, Serializer};
use uavspec_codegen::emit::docs::markdown::plural;

use super::{
    About, Case, CaseVerdict, Counts, Definition, Known, Outcome, Remark, Row, RuleVerdict, Subject, Testee,
    TesteeKind, Verdict,
};
use crate::check::{Coverage, Share, Unit, names};
use crate::definitions::Definitions;
use crate::model::Extent;
use crate::rules::rule;
use crate::testee::{case, outcome};

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
        let counts = counts(run.counts());
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
        let row = |((op, type_name), found): ((String, &str), outcome::Counts)| Row {
            op,
            type_name: type_name.to_owned(),
            counts: self::counts(found),
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
            checked: counts.pass + counts.fail + counts.known,
            duration_us: 0,
            outcome,
            rules,
            findings: Vec::new(),
            more_findings: 0,
            corruption: Vec::new(),
            more_corruption: 0,
            extent: Extent::Whole,
            coverage,
            incomplete: Vec::new(),
            cut_short: Vec::new(),
            notes: Vec::new(),
            elapsed: 0,
        }
    }
}

impl Testee {
    /// The rows with cases that the testee supports.
    pub(super) fn supported(&self) -> impl Iterator<Item = &Row> {
        self.table.iter().filter(|row| row.is_supported())
    }

    /// The types that the testee doesn't support, by operation. The first item contains the types without any supported
    /// operation; its operation is empty. The other items don't repeat these types.
    pub(super) fn unsupported(&self) -> Vec<(&str, Vec<&str>)> {
        let supported: BTreeSet<&str> = self.supported().map(|row| &*row.type_name).collect();
        let mut by_op: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for row in self.table.iter().filter(|row| !row.is_supported()) {
            let op = if supported.contains(&*row.type_name) { &*row.op } else { "" };
            by_op.entry(op).or_default().insert(&row.type_name);
        }
        by_op.into_iter().map(|(op, types)| (op, types.into_iter().collect())).collect()
    }

    /// Lines such as `140 types: px4/ActuatorTest, px4/Airspeed and 138 more`, one for each operation.
    pub(super) fn unsupported_lines(&self) -> Vec<String> {
        let line = |(op, types): (&str, Vec<&str>)| {
            let number = plural(types.len() as u64, "type");
            let of = if op.is_empty() { String::new() } else { format!("{op} of ") };
            format!("{of}{number}: {}", names(types.into_iter()))
        };
        self.unsupported().into_iter().map(line).collect()
    }
}

impl Row {
    fn is_supported(&self) -> bool {
        self.counts.checked() + self.counts.not_run > 0
    }
}

/// The types with at least one checked case, and the checked cases.
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

fn counts(counts: outcome::Counts) -> Counts {
    Counts {
        pass: counts.passed as u64,
        fail: counts.failed as u64,
        known: counts.known as u64,
        unsupported: counts.unsupported as u64,
        not_run: counts.not_run as u64,
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
    let mut found = Case {
        op: requested.action(),
        type_name: requested.type_name.clone(),
        description: requested.description.clone(),
        rule: requested.rule.clone(),
        verdict: CaseVerdict::Pass,
        path: String::new(),
        expected: String::new(),
        actual: String::new(),
        message: String::new(),
        stderr: String::new(),
        definition: span.map(|span| Definition::new(definitions.line(span))),
        reproduce: rerun_command(&name),
        known: None,
        name,
    };
    let verdict = match verdict {
        outcome::Verdict::Known { failure, excuse } => {
            found.known = Some(Known::from(excuse));
            failure
        }
        other => other,
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

/// The verdict of each rule that is violated by the input of at least one case. A rule passes if the testee rejects all
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

/// Serializes the cases that did not pass. The thousands of other cases are only counted.
pub(super) fn not_passed<S: Serializer>(cases: &[Case], serializer: S) -> Result<S::Ok, S::Error> {
    let others: Vec<&Case> = cases.iter().filter(|case| case.verdict != CaseVerdict::Pass).collect();
    others.serialize(serializer)
}
