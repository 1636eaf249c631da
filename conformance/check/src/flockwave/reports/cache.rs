//! The check results for status reports, keyed by the properties that determine the results.

use std::collections::BTreeSet;

use uavspec_flockwave::record::{Connection, Direction, SessionRecord};
use uavspec_flockwave::session::Sessions;
use uavspec_model::json::Tree;
use uavspec_model::{Findings, Location, Rule};
use uavspec_rules::RuleContext;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::{Check, Message, RULES};

use crate::limits::{MAX_KNOWN, MAX_KNOWN_TEXT};

/// The maximum number of findings in a counted report. The general path limits the number of findings in each body.
const MAX_VIOLATIONS: u64 = 1_000;

/// The properties that determine the findings in a state. The state's values must match their schemas or be null, and
/// the state's id must be the UAV's id.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Kind<'k> {
    /// One bit for each field, set if the field is present.
    pub(super) fields: u64,
    /// One bit for each field, set if the field is null.
    pub(super) nulls: u64,
    /// The error codes as written in the message; may be empty.
    pub(super) errors: &'k str,
}

/// The known results for reports.
pub(super) struct Known<'d> {
    definitions: &'d Definitions,
    /// The results for a report without states, by version.
    versions: Vec<Entry<Box<str>>>,
    /// The results that a state adds, by the state's kind: present fields, null fields and error codes.
    kinds: Vec<Entry<(u64, u64, Box<str>)>>,
}

/// The results for a version or a kind.
struct Entry<K> {
    key: K,
    /// The results; `None` if they are unknown.
    outcome: Option<Outcome>,
    /// True if the entry's findings have enough examples, so further findings are only counted.
    is_settled: bool,
    /// The UAVs whose findings have been reported since `is_settled` became true. The first report of each UAV is
    /// checked in full, because the messages of findings contain the UAV's id.
    reported_uavs: BTreeSet<Box<str>>,
    /// The number of counted reports or states.
    times: u64,
}

/// The results of all checks that receive only the message.
pub(super) struct Outcome {
    /// The number of times each rule is covered.
    covered: Vec<(&'static Rule, u64)>,
    /// The violations: rule, subject and count.
    violations: Vec<(&'static Rule, String, u64)>,
}

impl<K> Entry<K> {
    fn new(key: K, outcome: Option<Outcome>) -> Self {
        Self { key, outcome, is_settled: false, reported_uavs: BTreeSet::new(), times: 0 }
    }

    /// The number of findings in this entry, if they need only be counted for this UAV. Returns `None` if the caller
    /// must report them now; for later reports, they are then only counted.
    fn settled(&mut self, uav: &str, findings: &Findings) -> Option<u64> {
        let violations = &self.outcome.as_ref()?.violations;
        if violations.is_empty() {
            return Some(0);
        }
        self.is_settled = self.is_settled
            || violations.iter().all(|(rule, subject, _)| findings.has_examples(rule, subject));
        if !self.is_settled {
            return None;
        }
        if !self.reported_uavs.contains(uav) {
            if self.reported_uavs.len() < MAX_KNOWN && uav.len() <= MAX_KNOWN_TEXT {
                self.reported_uavs.insert(uav.into());
            }
            return None;
        }
        Some(violations.iter().map(|(.., count)| count).sum())
    }
}

impl<'d> Known<'d> {
    pub(super) fn new(definitions: &'d Definitions) -> Self {
        Self { definitions, versions: Vec::new(), kinds: Vec::new() }
    }

    /// The index of a version.
    fn version(&mut self, version: &str) -> Option<usize> {
        let found = self.versions.iter().position(|known| *known.key == *version);
        let at = found.unwrap_or(self.versions.len());
        if found.is_none() {
            if at == MAX_KNOWN || version.len() > MAX_KNOWN_TEXT {
                return None;
            }
            let outcome = self.check(version, "");
            self.versions.push(Entry::new(version.into(), outcome));
        }
        Some(at)
    }

    /// The index of a kind. A new kind is learned from a UAV and its state.
    pub(super) fn kind(&mut self, kind: Kind<'_>, (uav, state): (&str, &str)) -> Option<usize> {
        let known = self.kinds.iter().position(|known| {
            let (fields, nulls, errors) = &known.key;
            (*fields, *nulls, &**errors) == (kind.fields, kind.nulls, kind.errors)
        });
        known.or_else(|| self.learn(kind, uav, state))
    }

    fn learn(&mut self, kind: Kind<'_>, uav: &str, state: &str) -> Option<usize> {
        if self.kinds.len() == MAX_KNOWN || kind.errors.len() > MAX_KNOWN_TEXT {
            return None;
        }
        // The version doesn't change the results for a state.
        let with = self.check("1.0", &format!("\"{uav}\":{state}"));
        let outcome = with.zip(self.check("1.0", "")).and_then(|(with, without)| with.beyond(without));
        self.kinds.push(Entry::new((kind.fields, kind.nulls, kind.errors.into()), outcome));
        Some(self.kinds.len() - 1)
    }

    /// Runs all checks that receive only the message. Returns `None` if the message can't be checked.
    fn check(&self, version: &str, states: &str) -> Option<Outcome> {
        let text = format!(
            "{{\"$fw.version\":\"{version}\",\"id\":\"1\",\"body\":{{\"type\":\"{}\",\"status\":{{{states}}}}}}}",
            super::Report::TYPE
        );
        let message = Tree::read(&text).ok()?;
        let record = SessionRecord {
            connection: Connection { index: 0, name: "", is_ordered: false, is_lossy: true },
            direction: Direction::In,
            time: None,
            text: &text,
            value: Some(&message),
            trial: None,
            note: None,
            location: Location::Line(1),
        };
        let definitions = self.definitions;
        let exchange = Sessions::default().follow(&record, definitions.body_schemas());
        let mut findings = Findings::default();
        let message = Message::from_exchange(&exchange)?;
        let mut all = Vec::new();
        let checks = RULES.iter().flat_map(|rule| rule.checks.iter().map(|check| (&rule.rule, check)));
        for (rule, check) in checks {
            let Check::Message(check) = check else { continue };
            let mut covered = 0;
            check(
                &message,
                &mut RuleContext {
                    rule,
                    definitions,
                    events: &definitions.events,
                    findings: &mut findings,
                    coverage: &mut covered,
                },
            );
            all.push((rule, covered));
        }
        let violations = findings.groups().map(|group| (group.rule, group.subject.clone(), group.count));
        Some(Outcome { covered: all, violations: violations.collect() })
    }

    /// Counts a report with this version, and with states of these kinds and UAVs. Returns `None`, without counting, if
    /// any of their findings must be reported.
    pub(super) fn count<'u>(
        &mut self,
        version: &str,
        states: impl Iterator<Item = (usize, &'u str)> + Clone,
        findings: &Findings,
    ) -> Option<()> {
        let version = self.version(version)?;
        self.versions[version].settled("", findings)?;
        let mut num_violations = 0;
        for (kind, uav) in states.clone() {
            num_violations += self.kinds[kind].settled(uav, findings)?;
        }
        if num_violations > MAX_VIOLATIONS {
            return None;
        }
        self.versions[version].times += 1;
        states.for_each(|(kind, _)| self.kinds[kind].times += 1);
        Some(())
    }

    /// The number of counted reports.
    pub(super) fn seen(&self) -> u64 {
        self.versions.iter().map(|known| known.times).sum()
    }

    /// Adds the results of all counted reports to the findings.
    pub(super) fn report_counted(&self, findings: &mut Findings) {
        let versions = self.versions.iter().map(|known| (&known.outcome, known.times));
        let kinds = self.kinds.iter().map(|known| (&known.outcome, known.times));
        for (outcome, times) in versions.chain(kinds) {
            let Some(outcome) = outcome else { continue };
            for (rule, count) in &outcome.covered {
                findings.cover(rule, count * times);
            }
            for (rule, subject, count) in &outcome.violations {
                findings.count(rule, subject, None, count * times);
            }
        }
    }
}

impl Outcome {
    /// The results that a state adds to the results for a report without states. Returns `None` if this difference
    /// can't be used, because the report without states has findings, or covers a rule more often than the report with
    /// the state. Every state of this kind is then checked in full.
    fn beyond(self, without: Self) -> Option<Self> {
        let is_sound = without.violations.is_empty();
        let counts = self.covered.into_iter().zip(without.covered);
        let covered = counts.map(|((rule, with), (_, without))| Some((rule, with.checked_sub(without)?)));
        let covered = covered.collect::<Option<_>>().filter(|_| is_sound)?;
        Some(Self { covered, violations: self.violations })
    }
}
