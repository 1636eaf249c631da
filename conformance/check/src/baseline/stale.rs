//! Finds the entries of a list that are stale after a run.

use std::collections::BTreeMap;

use uavspec_model::{Excuse, ExcuseKind, Rule, SubjectName};
use uavspec_schema::Date;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;

use super::{Entry, Lists, Pattern, Selector};
use crate::topic::topic_of;

/// The maximum length, in bytes, of a pattern that is underlined in full in messages. Automatic fixes may write
/// patterns of any length.
const MAX_MARKED: u32 = 200;

/// The result of a case, or of a rule for a subject in a file.
#[derive(Clone, Debug)]
pub struct Checked<'r> {
    /// The name that entries match.
    pub name: Name<'r>,
    /// The result.
    pub outcome: Outcome,
}

/// The name of a result.
#[derive(Clone, Copy, Debug)]
pub enum Name<'r> {
    /// A rule, applied to a subject in a file.
    Rule {
        /// The rule.
        rule: &'static Rule,
        /// The subject of the violation; empty if there is none.
        subject: SubjectName<'r>,
        /// The path of the file as passed to the run.
        file: &'r str,
    },
    /// A case.
    Case(&'r str),
}

/// The result of a case or rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Passed. A rule gets this result for each file in which it checked anything. The rule's violations in that file
    /// are separate results.
    Passed,
    /// Failed, with these messages.
    Failed(Vec<String>),
    /// There was nothing to check.
    Idle,
    /// Not run, so it might fail.
    NotRun,
}

/// The kind of entries that a run checks for staleness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Entries for rules.
    Rules,
    /// Entries for cases.
    Cases,
}

/// A stale entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stale {
    /// The index among all entries.
    pub(super) entry: usize,
    /// The reason.
    pub reason: StaleReason,
}

impl Stale {
    /// True if the entry can be fixed automatically. If messages have no common prefix, a fix isn't possible, since an
    /// empty prefix would excuse any failure.
    pub fn is_fixable(&self) -> bool {
        !matches!(&self.reason, StaleReason::FailsOtherwise { common, .. } if common.is_empty())
    }
}

/// The reason why an entry is stale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StaleReason {
    /// All matching results pass.
    Passes,
    /// Some of the matching cases pass.
    PassesInPart {
        /// The number of cases that pass.
        count: usize,
        /// The first case that passes.
        first: String,
        /// The cases that fail.
        failing: Vec<String>,
    },
    /// A failure has a different message.
    FailsOtherwise {
        /// The first unexpected message.
        found: String,
        /// The common prefix of all messages.
        common: String,
    },
    /// Nothing in the run matches.
    MatchesNothing,
    /// There was nothing to check for the entry.
    Idle,
    /// The expiry date has passed.
    Expired,
}

/// The results of a run, counted for each entry of the lists. The results themselves aren't kept.
#[derive(Debug)]
pub struct Sums {
    /// The counts of the entries within the scope.
    by_entry: BTreeMap<usize, Sum>,
    /// The entries of each rule, so that lists with many entries stay fast.
    by_rule: BTreeMap<&'static str, Vec<usize>>,
}

/// The counts and messages of all results that an entry matches.
#[derive(Clone, Debug, Default)]
struct Sum {
    passed: usize,
    /// The first case that passed; `None` for rules.
    passing: Option<String>,
    /// The cases that failed.
    failing: Vec<String>,
    failed: usize,
    idle: usize,
    not_run: usize,
    /// The first unexpected message.
    other: Option<String>,
    common: Option<String>,
}

impl Lists {
    /// The reason why a failure is excused, if an entry matches the failure's name and all its messages.
    pub fn excuse(&self, name: Name<'_>, messages: &[String]) -> Option<&Excuse> {
        let subjects = name.subjects();
        let excuses = |entry: &&Entry| {
            entry.names.is_match(name, Some(&subjects))
                && messages.iter().all(|message| entry.expects(message))
        };
        // Known failures take precedence over flaky results.
        let found =
            self.entries.iter().filter(excuses).min_by_key(|entry| entry.excuse.kind == ExcuseKind::Flaky);
        found.map(|entry| &entry.excuse)
    }

    /// Starts to count results.
    pub fn sums(&self, scope: Scope) -> Sums {
        let mut sums = Sums { by_entry: BTreeMap::new(), by_rule: BTreeMap::new() };
        for (at, entry) in self.entries.iter().enumerate() {
            match &entry.names {
                Selector::Rule { rule, .. } if scope == Scope::Rules => {
                    sums.by_rule.entry(rule.id).or_default().push(at);
                }
                Selector::Case(_) if scope == Scope::Cases => {}
                Selector::Rule { .. } | Selector::Case(_) => continue,
            }
            sums.by_entry.insert(at, Sum::default());
        }
        sums
    }

    /// Counts a result for each entry that it matches.
    pub fn count(&self, sums: &mut Sums, checked: &Checked<'_>) {
        let Sums { by_entry, by_rule } = sums;
        let is_failure = matches!(checked.outcome, Outcome::Failed(_));
        let subjects = is_failure.then(|| checked.name.subjects());
        let count = |at: usize, sum: &mut Sum| {
            let is_match = |entry: &&Entry| entry.names.is_match(checked.name, subjects.as_deref());
            let entry = self.entries.get(at).filter(is_match);
            if let Some(entry) = entry {
                sum.add(entry, checked);
            }
        };
        match checked.name {
            Name::Case(_) => by_entry.iter_mut().for_each(|(at, sum)| count(*at, sum)),
            Name::Rule { rule, .. } => {
                for at in by_rule.get(rule.id).into_iter().flatten() {
                    if let Some(sum) = by_entry.get_mut(at) {
                        count(*at, sum);
                    }
                }
            }
        }
    }

    /// The entries that are stale on `today`, in order.
    pub fn stale(&self, sums: &Sums, today: Date) -> Vec<Stale> {
        let mut stale = Vec::new();
        for (at, sum) in &sums.by_entry {
            let Some(Entry { excuse, .. }) = self.entries.get(*at) else { continue };
            let is_over = excuse.expires.is_some_and(|last| last < today);
            let reasons =
                is_over.then_some(StaleReason::Expired).into_iter().chain(sum.clone().reasons(excuse.kind));
            stale.extend(reasons.map(|reason| Stale { entry: *at, reason }));
        }
        stale
    }

    /// The entries that are stale after a run with these results.
    pub fn find_stale(&self, scope: Scope, checked: &[Checked<'_>], today: Date) -> Vec<Stale> {
        let mut sums = self.sums(scope);
        for checked in checked {
            self.count(&mut sums, checked);
        }
        self.stale(&sums, today)
    }

    /// The finding for a stale entry.
    pub(super) fn finding(&self, stale: &Stale, level: Level) -> Option<Finding> {
        let entry = self.entries.get(stale.entry)?;
        let mut spans = entry.spans;
        if spans.selector.end - spans.selector.start > MAX_MARKED {
            spans.selector = spans.header;
        }
        let noun = match &entry.names {
            Selector::Rule { .. } => "rule",
            Selector::Case(_) => "case",
        };
        let (id, span, message, help) = match &stale.reason {
            StaleReason::Passes => {
                let message = format!("this {noun} matches only passing results");
                ("baseline-passes", spans.selector, message, "remove the entry")
            }
            StaleReason::PassesInPart { count, first, failing } => {
                let all = count + failing.len();
                let message = format!("{count} of {all} matching cases pass; the first is {first}");
                let help = "match only the cases that fail; use `[[flaky]]` for cases that sometimes pass";
                ("baseline-passes", spans.selector, message, help)
            }
            StaleReason::FailsOtherwise { found, .. } => {
                let expected = entry.message.as_deref()?;
                let message =
                    format!("the message differs: expected {expected:?} at the start, found {found:?}");
                let help = "investigate the failure; if the new failure is known too, update the message";
                ("baseline-fails-otherwise", spans.message?, message, help)
            }
            StaleReason::MatchesNothing => {
                let message = format!("nothing in this run matches this {noun}");
                ("baseline-unmatched", spans.selector, message, "correct the pattern, or remove the entry")
            }
            StaleReason::Idle => {
                let message = format!("there was nothing to check for this {noun}");
                ("baseline-unmatched", spans.selector, message, "correct the pattern, or remove the entry")
            }
            StaleReason::Expired => {
                let message = format!("the entry expired on {}", entry.excuse.expires?);
                let help = "remove the entry, or set a later date if the reason still applies";
                ("baseline-expired", spans.expires?, message, help)
            }
        };
        let mut finding = Finding::new(id, level, span, message);
        finding.help(help);
        Some(finding)
    }
}

impl Selector {
    /// True if the entry matches this name, with these forms of its subject. Results without violations have no subject
    /// to match.
    fn is_match(&self, name: Name<'_>, subjects: Option<&[String]>) -> bool {
        match (self, name) {
            (Self::Rule { rule, subject, file }, Name::Rule { rule: id, file: path, .. }) => {
                let is_named = |pattern: &Pattern| {
                    subjects.is_none_or(|subjects| subjects.iter().any(|subject| pattern.is_match(subject)))
                };
                rule.id == id.id
                    && file.as_ref().is_none_or(|file| file.is_match(path))
                    && subject.as_ref().is_none_or(is_named)
            }
            (Self::Case(pattern), Name::Case(name)) => pattern.is_match(name),
            (Self::Rule { .. }, Name::Case(_)) | (Self::Case(_), Name::Rule { .. }) => false,
        }
    }
}

impl Name<'_> {
    /// The forms of the subject that patterns match: the full name, the name without the instance, and the name that also
    /// lacks the namespace of the topic. Each entry is compared with these forms.
    fn subjects(self) -> Vec<String> {
        let Self::Rule { rule, subject, .. } = self else { return Vec::new() };
        let topic = (!rule.is_on_flockwave()).then(|| without_namespace(subject.name));
        [subject.to_string(), subject.name.to_owned()].into_iter().chain(topic).collect()
    }
}

/// The name of a topic or field without the namespace of the topic: `locked.data` of `/kite/winch/locked.data`.
fn without_namespace(name: &str) -> String {
    let last = name.rfind('/').map_or(0, |at| at + 1);
    let end = name[last..].find('.').map_or(name.len(), |at| last + at);
    let (topic, field) = name.split_at(end);
    format!("{}{field}", topic_of(topic))
}

impl Entry {
    fn expects(&self, message: &str) -> bool {
        self.message.as_ref().is_none_or(|prefix| message.starts_with(prefix.as_str()))
    }
}

impl Sum {
    fn add(&mut self, entry: &Entry, checked: &Checked<'_>) {
        let case = match checked.name {
            Name::Case(case) => Some(case),
            Name::Rule { .. } => None,
        };
        match &checked.outcome {
            Outcome::Passed => {
                self.passed += 1;
                self.passing = self.passing.take().or_else(|| case.map(str::to_owned));
            }
            Outcome::Idle => self.idle += 1,
            Outcome::NotRun => self.not_run += 1,
            Outcome::Failed(messages) => {
                self.failed += 1;
                self.failing.extend(case.map(str::to_owned));
                for message in messages {
                    self.fails(entry, message);
                }
            }
        }
    }

    fn fails(&mut self, entry: &Entry, message: &str) {
        if self.other.is_none() && !entry.expects(message) {
            self.other = Some(message.to_owned());
        }
        let common = self.common.get_or_insert_with(|| message.to_owned());
        let pairs = common.chars().zip(message.chars());
        let length = pairs.take_while(|(left, right)| left == right).map(|(left, _)| left.len_utf8()).sum();
        common.truncate(length);
    }

    fn reasons(mut self, kind: ExcuseKind) -> impl Iterator<Item = StaleReason> {
        let found = self.other.take().filter(|_| kind == ExcuseKind::Known);
        let common = self.common.take().unwrap_or_default();
        let otherwise = found.map(|found| StaleReason::FailsOtherwise { found, common });
        otherwise.into_iter().chain(self.reason_to_remove(kind))
    }

    /// The reason to remove or narrow an entry, if there is one. Failure messages don't matter here.
    fn reason_to_remove(self, kind: ExcuseKind) -> Option<StaleReason> {
        // A case that wasn't run might fail.
        if self.not_run > 0 {
            return None;
        }
        match (self.failed, self.passed, self.idle) {
            (0, 0, 0) => Some(StaleReason::MatchesNothing),
            (0, 0, _) => Some(StaleReason::Idle),
            _ if kind == ExcuseKind::Flaky => None,
            (0, _, _) => Some(StaleReason::Passes),
            (_, count, _) => {
                let failing = self.failing;
                self.passing.map(|first| StaleReason::PassesInPart { count, first, failing })
            }
        }
    }
}
