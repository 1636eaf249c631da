//! The findings of all subjects, grouped by rule.
//!
//! Only the groups and files that reports list are kept. The others are counted.

use std::cmp::Reverse;
use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{Hash as _, Hasher as _};

use uavspec_model::Excuse;
use uavspec_model::text::thousands;
use uavspec_rules::px4;

use crate::{Example, Finding, Report, RuleReport, Subject, Verdict};

/// The maximum number of groups with the same rule and verdict that are kept. Reports list at most this number of
/// groups of a rule.
const MAX_GROUPS: usize = 54;

/// The maximum number of groups that are kept.
const MAX_ALL_GROUPS: usize = 4_000;

/// The maximum number of other files that are kept for each group.
pub(crate) const MAX_FILES: usize = 20;

/// The maximum number of other files that are kept for all groups.
const MAX_ALL_FILES: usize = 20_000;

/// The maximum number of groups of a rule that are counted but not kept.
const MAX_UNKEPT: usize = 10_000;

/// The groups of all subjects that have been added.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    rules: BTreeMap<&'static str, OfRule>,
    num_kept: usize,
    num_files: usize,
}

/// The groups of a rule.
#[derive(Debug, Default)]
struct OfRule {
    /// The groups in the order of appearance.
    kept: Vec<Group>,
    /// The hashes of the names and verdicts of the groups that aren't kept.
    others: BTreeSet<u64>,
}

/// The findings of one rule in one topic or field that have the same verdict.
#[derive(Debug)]
pub(crate) struct Group {
    /// The topic or field.
    pub(crate) name: String,
    pub(crate) verdict: Verdict,
    /// The number of findings.
    pub(crate) count: u64,
    /// The path of the first file or server.
    pub(crate) path: String,
    /// True if lines of the first file can be looked up.
    pub(crate) is_readable_again: bool,
    /// The first finding.
    pub(crate) first: Finding,
    /// The findings in other files, for the first of these files.
    pub(crate) others: Vec<OtherFile>,
    /// The number of other files.
    pub(crate) num_others: usize,
}

/// The findings of a group in another file.
#[derive(Debug)]
pub(crate) struct OtherFile {
    pub(crate) path: String,
    /// The number of findings.
    pub(crate) count: u64,
    /// The location and the text of the first finding.
    pub(crate) first: Option<(String, String)>,
    pub(crate) known: Option<Excuse>,
}

/// The rules of a report, the most severe verdict first.
pub(crate) struct ByRule<'r> {
    /// The rules whose findings are listed.
    pub(crate) listed: Vec<Listed<'r>>,
    /// All other rules.
    pub(crate) others: Vec<&'r RuleReport>,
}

/// A rule with its findings.
pub(crate) struct Listed<'r> {
    pub(crate) rule: &'r RuleReport,
    /// The first groups, the most severe verdict first.
    pub(crate) groups: Vec<&'r Group>,
    /// The number of all groups.
    pub(crate) num_groups: usize,
}

impl Groups {
    /// Adds the findings of a subject.
    pub(crate) fn add(&mut self, subject: &Subject) {
        for finding in &subject.findings {
            let of_rule = self.rules.entry(finding.rule).or_default();
            let mut same = of_rule.kept.iter_mut().filter(|group| group.verdict == finding.verdict);
            if let Some(group) = same.find(|group| group.name == finding.subject) {
                group.count += finding.count;
                group.num_others += 1;
                if group.others.len() < MAX_FILES && self.num_files < MAX_ALL_FILES {
                    self.num_files += 1;
                    group.others.push(OtherFile::new(subject, finding));
                }
                continue;
            }
            let num_kept = of_rule.kept.iter().filter(|group| group.verdict == finding.verdict).count();
            if num_kept < MAX_GROUPS && self.num_kept < MAX_ALL_GROUPS {
                self.num_kept += 1;
                of_rule.kept.push(Group::new(subject, finding));
            } else if of_rule.others.len() < MAX_UNKEPT {
                let mut hasher = DefaultHasher::new();
                (&finding.subject, finding.verdict).hash(&mut hasher);
                of_rule.others.insert(hasher.finish());
            }
        }
    }

    /// The rules of a report with their groups.
    pub(crate) fn by_rule<'r>(&'r self, report: &'r Report) -> ByRule<'r> {
        let mut rules: Vec<&RuleReport> = report.rules.iter().collect();
        rules.sort_by_key(|rule| Reverse(rule.verdict));
        let (mut listed, mut others) = (Vec::new(), Vec::new());
        for rule in rules {
            match self.rules.get(rule.id).filter(|_| !is_in_summary(rule)) {
                Some(of_rule) => {
                    let mut groups: Vec<&Group> = of_rule.kept.iter().collect();
                    groups.sort_by_key(|group| Reverse(group.verdict));
                    let num_groups = groups.len() + of_rule.others.len();
                    listed.push(Listed { rule, groups, num_groups });
                }
                None => others.push(rule),
            }
        }
        ByRule { listed, others }
    }
}

/// True if the summary of each file lists the findings of this rule, because they are format differences that aren't
/// failures.
fn is_in_summary(rule: &RuleReport) -> bool {
    rule.id == px4::FMT_01.rule.id && rule.verdict != Verdict::Fail
}

impl Listed<'_> {
    /// The number of findings beyond the first groups.
    pub(crate) fn more_than(&self, num_groups: usize) -> u64 {
        let listed: u64 = self.groups.iter().take(num_groups).map(|group| group.count).sum();
        self.rule.findings.saturating_sub(listed)
    }
}

impl OtherFile {
    fn new(subject: &Subject, finding: &Finding) -> Self {
        let first = finding.examples.first();
        Self {
            path: subject.path.clone(),
            count: finding.count,
            first: first.map(|first| (place(subject.is_readable_again, first), first.text())),
            known: finding.known.clone(),
        }
    }
}

impl Group {
    fn new(subject: &Subject, finding: &Finding) -> Self {
        Self {
            name: finding.subject.clone(),
            verdict: finding.verdict,
            count: finding.count,
            path: subject.path.clone(),
            is_readable_again: subject.is_readable_again,
            first: finding.clone(),
            others: Vec::new(),
            num_others: 0,
        }
    }

    /// The number of findings, and the location of the first one. If there are several files, the text names the first
    /// file.
    pub(crate) fn places(&self, is_single: bool) -> Option<String> {
        let place = place(self.is_readable_again, self.first.examples.first()?);
        let times = match (self.count, self.num_others as u64 + 1) {
            (1, _) => "Once,".to_owned(),
            (count, 1) => format!("{} times, first", thousands(count)),
            (count, files) => format!("{} times in {} files, first", thousands(count), thousands(files)),
        };
        let file = if is_single { String::new() } else { format!("in {} ", self.path) };
        Some(format!("{times} {file}{place}").trim_end_matches([' ', ',']).to_owned())
    }
}

/// The location of an example, with its time and its connection if they are known. A session that wasn't recorded has
/// no lines to look up, so its location is left out.
pub(crate) fn place(is_readable_again: bool, example: &Example) -> String {
    let location = is_readable_again.then(|| format!("at {}", example.location));
    let parts = location.into_iter().chain(Some(example.moment()).filter(|moment| !moment.is_empty()));
    parts.collect::<Vec<_>>().join(" ")
}
