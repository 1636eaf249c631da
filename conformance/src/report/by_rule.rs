//! The findings of all subjects, grouped by rule.

use std::collections::BTreeMap;

use crate::report::{Example, Finding, Report, RuleReport, Subject, Verdict};
use crate::rules::px4;
use crate::text::Grouped;

/// The rules of a report, the most severe verdict first.
pub(in crate::report) struct ByRule<'r> {
    /// The rules whose findings are listed.
    pub(in crate::report) listed: Vec<Listed<'r>>,
    /// All other rules.
    pub(in crate::report) others: Vec<&'r RuleReport>,
}

/// A rule with its findings.
pub(in crate::report) struct Listed<'r> {
    pub(in crate::report) rule: &'r RuleReport,
    /// The groups, the most severe verdict first.
    pub(in crate::report) groups: Vec<Group<'r>>,
}

/// The findings of a rule in one topic or field, with the same verdict.
pub(in crate::report) struct Group<'r> {
    /// The topic or field.
    pub(in crate::report) name: &'r str,
    pub(in crate::report) verdict: Verdict,
    /// The first finding, with its file or server.
    pub(in crate::report) first: (&'r Subject, &'r Finding),
    /// The findings in other files.
    pub(in crate::report) others: Vec<(&'r Subject, &'r Finding)>,
}

impl<'r> ByRule<'r> {
    pub(in crate::report) fn new(report: &'r Report) -> Self {
        let mut groups = groups(report);
        let mut rules: Vec<&RuleReport> = report.rules.iter().collect();
        rules.sort_by_key(|rule| std::cmp::Reverse(rule.verdict));
        let (mut listed, mut others) = (Vec::new(), Vec::new());
        for rule in rules {
            match groups.remove(rule.id).filter(|_| !is_in_summary(rule)) {
                Some(groups) => listed.push(Listed { rule, groups }),
                None => others.push(rule),
            }
        }
        Self { listed, others }
    }
}

/// True if the summary of each file lists the findings. This applies to format differences that are not failures.
fn is_in_summary(rule: &RuleReport) -> bool {
    rule.id == px4::FMT_01.rule.id && rule.verdict != Verdict::Fail
}

/// The groups of each rule.
fn groups(report: &Report) -> BTreeMap<&str, Vec<Group<'_>>> {
    let mut groups: BTreeMap<&str, Vec<Group>> = BTreeMap::new();
    let mut positions = BTreeMap::new();
    for subject in &report.subjects {
        for finding in &subject.findings {
            let Finding { rule, subject: name, verdict, .. } = finding;
            let groups = groups.entry(rule).or_default();
            let position = *positions.entry((rule, name, *verdict)).or_insert(groups.len());
            match groups.get_mut(position) {
                Some(group) => group.others.push((subject, finding)),
                None => groups.push(Group {
                    name,
                    verdict: *verdict,
                    first: (subject, finding),
                    others: Vec::new(),
                }),
            }
        }
    }
    for groups in groups.values_mut() {
        groups.sort_by_key(|group| std::cmp::Reverse(group.verdict));
    }
    groups
}

impl Listed<'_> {
    /// The number of findings that were counted but not grouped.
    pub(in crate::report) fn ungrouped(&self) -> u64 {
        let grouped: u64 = self.groups.iter().map(Group::count).sum();
        self.rule.findings.saturating_sub(grouped)
    }
}

impl Group<'_> {
    pub(in crate::report) fn count(&self) -> u64 {
        self.first.1.count + self.others.iter().map(|(_, finding)| finding.count).sum::<u64>()
    }

    /// The number of findings, and the place of the first one. If there are several files, the first file is named.
    pub(in crate::report) fn places(&self, is_single: bool) -> Option<String> {
        let (subject, finding) = self.first;
        let place = place(subject, finding.examples.first()?);
        let times = match (self.count(), self.others.len() as u64 + 1) {
            (1, _) => "Once,".to_owned(),
            (count, 1) => format!("{} times, first", Grouped(count)),
            (count, files) => format!("{} times in {} files, first", Grouped(count), Grouped(files)),
        };
        let file = if is_single { String::new() } else { format!("in {} ", subject.path) };
        Some(format!("{times} {file}{place}").trim_end_matches([' ', ',']).to_owned())
    }
}

/// The location of an example, its time and its connection, if they are known.
pub(in crate::report) fn place(subject: &Subject, example: &Example) -> String {
    // A session that wasn't recorded has no lines.
    let location = subject.is_readable_again.then(|| format!("at {}", example.location));
    let parts = location.into_iter().chain(Some(example.moment()).filter(|moment| !moment.is_empty()));
    parts.collect::<Vec<_>>().join(" ")
}
