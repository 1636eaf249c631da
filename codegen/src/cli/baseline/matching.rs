//! Compares findings with the entries of a list.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use uavspec_dynamic::breaking;
use uavspec_schema::Date;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;

use super::read::{Entry, List, Subject};
use super::subject::Subjects;

/// A subject and a rule.
type Group = (String, &'static str);

/// The findings of a run by rule and subject. Parser errors are not included, because they can't be known findings.
pub(super) struct Found {
    /// The indexes of the first finding of each change.
    pub(super) groups: BTreeMap<Group, Vec<usize>>,
    /// The change of each finding: the index of its first finding.
    changes: Vec<usize>,
}

impl Found {
    pub(super) fn new(findings: &[Finding], mut subjects: Subjects<'_>) -> Self {
        let mut groups: BTreeMap<Group, Vec<usize>> = BTreeMap::new();
        let mut changes = Vec::with_capacity(findings.len());
        for same in findings.chunk_by(Finding::is_same_change) {
            let first = changes.len();
            changes.extend(same.iter().map(|_| first));
            if uavspec_lint::rule(same[0].rule).is_some() || breaking::rule(same[0].rule).is_some() {
                groups.entry((subjects.of(&same[0]), same[0].rule)).or_default().push(first);
            }
        }
        Self { groups, changes }
    }
}

/// The result of a comparison.
pub(super) struct Matches {
    /// The number of findings that each entry matches.
    pub(super) counts: Vec<usize>,
    /// True for each entry that matches more findings than its count.
    pub(super) has_surplus: Vec<bool>,
    /// The entry of each group.
    entries: BTreeMap<Group, usize>,
    /// The outdated entries, in file order.
    pub(super) outdated: Vec<Outdated>,
    /// Explanations for entries with more findings than their count.
    pub(super) surplus: Vec<String>,
}

/// An outdated entry.
pub(super) struct Outdated {
    /// The index of the entry.
    pub(super) entry: usize,
    pub(super) reason: Reason,
}

/// The reason why an entry is outdated.
pub(super) enum Reason {
    Expired,
    /// No finding matches.
    Unmatched,
    /// Fewer findings match than `count`.
    Fewer(usize),
}

impl Matches {
    /// Compares the findings of a run on `today`.
    pub(super) fn new(list: &List, found: &Found, today: Date, is_applied: &dyn Fn(&str) -> bool) -> Self {
        let index = Index::new(list);
        let mut counts = vec![0; list.entries.len()];
        let mut entries = BTreeMap::new();
        for ((subject, rule), changes) in &found.groups {
            if let Some(entry) = index.find(rule, subject) {
                counts[entry] += changes.len();
                entries.insert((subject.clone(), *rule), entry);
            }
        }
        let has_surplus: Vec<bool> = (list.entries.iter().zip(&counts))
            .map(|(entry, found)| entry.count.is_some_and(|count| *found > count))
            .collect();
        let surplus = list.entries.iter().enumerate().filter(|(at, _)| has_surplus[*at]);
        let surplus = surplus.map(|(at, entry)| {
            let subject = list.sources.slice(entry.spans.subject);
            let count = entry.count.unwrap_or_default();
            format!(
                "{}: {subject} has {} findings instead of {count}; all are reported",
                entry.rule, counts[at]
            )
        });
        let outdated = list.entries.iter().enumerate().filter(|(_, entry)| is_applied(&entry.rule));
        let outdated = outdated.filter_map(|(at, entry)| {
            let reason = if entry.expires.is_some_and(|last| last < today) {
                Reason::Expired
            } else if counts[at] == 0 {
                Reason::Unmatched
            } else if entry.count.is_some_and(|count| counts[at] < count) {
                Reason::Fewer(counts[at])
            } else {
                return None;
            };
            Some(Outdated { entry: at, reason })
        });
        Self { outdated: outdated.collect(), surplus: surplus.collect(), has_surplus, counts, entries }
    }

    /// True if an entry covers all findings of a group.
    fn is_known(&self, group: &Group) -> bool {
        self.entries.get(group).is_some_and(|entry| !self.has_surplus[*entry])
    }

    /// The entry that matches a rule and a subject.
    pub(super) fn entry(&self, group: &Group) -> Option<usize> {
        self.entries.get(group).copied()
    }

    /// The number of known findings.
    pub(super) fn known(&self, found: &Found) -> usize {
        found.groups.iter().filter(|(group, _)| self.is_known(group)).map(|(_, changes)| changes.len()).sum()
    }

    /// Removes the known findings.
    pub(super) fn retain_new(&self, found: &Found, findings: &mut Vec<Finding>) {
        let known = found.groups.iter().filter(|(group, _)| self.is_known(group));
        let known: BTreeSet<usize> = known.flat_map(|(_, changes)| changes).copied().collect();
        let mut changes = found.changes.iter();
        findings.retain(|_| changes.next().is_none_or(|change| !known.contains(change)));
    }
}

impl Outdated {
    /// The finding about this entry.
    pub(super) fn finding(&self, entry: &Entry) -> Finding {
        let spans = &entry.spans;
        let (rule, span, message, help) = match self.reason {
            Reason::Expired => {
                let date = entry.expires.map(|date| date.to_string()).unwrap_or_default();
                let help = "remove the entry, or set a later date if the reason still applies".to_owned();
                ("baseline-expired", spans.expires, format!("the entry expired on {date}"), help)
            }
            Reason::Unmatched => {
                let message = format!("`{}` has no finding for this subject", entry.rule);
                ("baseline-unmatched", None, message, "remove the entry".to_owned())
            }
            Reason::Fewer(count) => {
                let known = entry.count.unwrap_or_default();
                let message = format!("`{}` has fewer findings: {count} instead of {known}", entry.rule);
                ("baseline-count", spans.count, message, format!("write `count = {count}`"))
            }
        };
        let mut finding = Finding::new(rule, Level::Error, span.unwrap_or(spans.subject), message);
        finding.help(help);
        finding
    }
}

/// The entries of a list by rule and subject.
struct Index<'l> {
    exact: HashMap<(&'l str, &'l str), usize>,
    patterns: Vec<(usize, &'l Entry)>,
}

impl<'l> Index<'l> {
    fn new(list: &'l List) -> Self {
        let mut index = Self { exact: HashMap::new(), patterns: Vec::new() };
        for (at, entry) in list.entries.iter().enumerate() {
            match &entry.subject {
                Subject::Exact(subject) => {
                    index.exact.entry((&entry.rule, subject)).or_insert(at);
                }
                Subject::Pattern(_) => index.patterns.push((at, entry)),
            }
        }
        index
    }

    /// The entry for a subject. Exact subjects take precedence over patterns.
    fn find(&self, rule: &str, subject: &str) -> Option<usize> {
        let is_match = |entry: &Entry| {
            entry.rule == rule
                && matches!(&entry.subject, Subject::Pattern(pattern) if pattern.is_match(subject))
        };
        let pattern = || self.patterns.iter().find(|(_, entry)| is_match(entry)).map(|(at, _)| *at);
        self.exact.get(&(rule, subject)).copied().or_else(pattern)
    }
}
