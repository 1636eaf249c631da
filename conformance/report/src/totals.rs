//! The results across all subjects of a run. They stay in memory, whereas subjects may be written and then dropped.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_check::Line;
use uavspec_model::Level;
use uavspec_rules::rule;

use super::{About, Counts, Outcome, OutcomeKind, RuleReport, RuleVerdict, Subject, Verdict};

/// The maximum number of remarks about single files in the outcome of a run.
const MAX_REMARKS: usize = 20;

/// The results across all subjects.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// The number of subjects.
    pub(super) subjects: usize,
    /// The first subject. Some reports describe a single subject in more detail.
    pub(super) first: Option<First>,
    /// The number of subjects with each outcome, and the highest exit status among them.
    kinds: BTreeMap<OutcomeKind, (usize, u8)>,
    /// The results of the rules by id.
    pub(super) rules: BTreeMap<&'static str, RuleReport>,
    /// The ids of the violated rules. The flag is true if the level is SHOULD.
    violated: BTreeSet<(&'static str, bool)>,
    /// The first remarks about subjects that weren't read or checked completely.
    remarks: Vec<String>,
    more_remarks: usize,
    /// The number of messages.
    pub(super) records: u64,
    /// The number of checked messages.
    pub(super) checked: u64,
    /// The counts of all testees; `None` if there are no testees.
    pub(super) cases: Option<Counts>,
}

/// The first subject.
#[derive(Clone, Debug)]
pub(super) struct First {
    pub(super) path: String,
    pub(super) outcome: Outcome,
    /// The coverage of the only subject, as lines for people. Empty if there are several subjects.
    pub(super) coverage: Vec<Line>,
}

impl Totals {
    /// The results across these subjects.
    pub fn of(subjects: &[Subject]) -> Self {
        let mut totals = Self::default();
        for subject in subjects {
            totals.add(subject);
        }
        totals
    }

    /// Adds the results of a subject.
    pub(crate) fn add(&mut self, subject: &Subject) {
        self.subjects += 1;
        match &mut self.first {
            Some(first) => first.coverage = Vec::new(),
            None => {
                self.first = Some(First {
                    path: subject.path.clone(),
                    outcome: subject.outcome.clone(),
                    coverage: subject.coverage_lines(),
                });
            }
        }
        let (count, status) = self.kinds.entry(subject.outcome.kind).or_default();
        *count += 1;
        *status = subject.outcome.status.max(*status);
        self.add_rules(subject);
        for reason in &subject.incomplete {
            if self.remarks.len() < MAX_REMARKS {
                self.remarks.push(format!("{}: {reason}", subject.path));
            } else {
                self.more_remarks += 1;
            }
        }
        self.records += subject.records;
        self.checked += subject.coverage.records.checked;
        if let About::Testee(testee) = &subject.about {
            let all: &mut Counts = self.cases.get_or_insert_default();
            all.passed += testee.counts.passed;
            all.failed += testee.counts.failed;
            all.known += testee.counts.known;
            all.unsupported += testee.counts.unsupported;
            all.not_run += testee.counts.not_run;
        }
    }

    fn add_rules(&mut self, subject: &Subject) {
        for found in &subject.rules {
            if is_violated(found) {
                self.violated.insert((found.id, found.level == Level::Should));
            }
            let Some(rule) = rule(found.id) else { continue };
            let report = self.rules.entry(rule.id).or_insert_with(|| RuleReport::new(rule));
            report.verdict = report.verdict.max(found.verdict);
            report.covered += found.covered;
            report.findings += found.findings;
        }
    }

    /// True if there is exactly one subject.
    pub(super) fn is_single(&self) -> bool {
        self.subjects == 1
    }

    /// The first subject, if it is the only one.
    pub(super) fn only(&self) -> Option<&First> {
        self.first.as_ref().filter(|_| self.is_single())
    }

    /// True if there are testees.
    pub(super) fn has_testees(&self) -> bool {
        self.cases.is_some()
    }

    /// The number of subjects with this outcome, and the highest exit status among them.
    pub(super) fn with(&self, kind: OutcomeKind) -> (usize, u8) {
        self.kinds.get(&kind).copied().unwrap_or_default()
    }

    /// The worst outcome. Subjects that have nothing to check are ignored.
    pub(super) fn worst(&self) -> Option<OutcomeKind> {
        self.kinds.keys().rev().copied().find(|kind| *kind != OutcomeKind::Nothing)
    }

    /// The number of violated rules that count as MUST, and the number of violated rules of level SHOULD. A rule that
    /// several subjects violate counts once.
    pub(super) fn violated(&self) -> (usize, usize) {
        kinds_of_violations(self.violated.iter().map(|(_, is_should)| *is_should))
    }

    /// The remarks about subjects that weren't read or checked completely.
    pub(super) fn remarks(&self) -> Vec<String> {
        let more = (self.more_remarks > 0).then(|| format!("… and {} more", self.more_remarks));
        self.remarks.iter().cloned().chain(more).collect()
    }

    /// True if a rule applies to anything in a subject.
    pub fn covers(&self, id: &str) -> bool {
        self.rules.get(id).is_some_and(|rule| rule.covered > 0)
    }
}

/// True if a rule of level MUST or SHOULD is violated.
pub(super) fn is_violated(rule: &RuleVerdict) -> bool {
    matches!(rule.verdict, Verdict::Warn | Verdict::Fail)
}

/// The number of violated rules that count as MUST, and the number of violated rules of level SHOULD. An item of
/// `violations` is true if the level is SHOULD.
pub(super) fn kinds_of_violations(violations: impl Iterator<Item = bool>) -> (usize, usize) {
    let (should, must): (Vec<bool>, Vec<bool>) = violations.partition(|is_should| *is_should);
    (must.len(), should.len())
}
