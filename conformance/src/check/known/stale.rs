//! Whether a list still holds true for what came of a run.

use std::collections::BTreeMap;

use uavspec_codegen::diagnostic::Level;
use uavspec_codegen::finding::Finding;

use super::{Entry, Lists, Selector};
use crate::model::Rule;
use crate::model::{Date, Excuse, ExcuseKind};

/// The longest pattern that is shown as a whole, in bytes: one that mending wrote may have any length.
const MAX_MARKED: u32 = 200;

/// Something that a run looked at, and what came of it.
#[derive(Clone, Debug)]
pub(crate) struct Checked<'r> {
    /// What it is called.
    pub name: Name<'r>,
    /// What came of it.
    pub outcome: Outcome,
}

/// What entries name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Name<'r> {
    /// A rule, on something in a file.
    Rule {
        /// The rule.
        rule: &'static Rule,
        /// What breaks it; empty where nothing does.
        subject: &'r str,
        /// The file, as the run was given it.
        file: &'r str,
    },
    /// A case.
    Case(&'r str),
}

/// What came of something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It is as it should be. Of a rule: it was judged, and all that breaks it in this file stands beside this.
    Passed,
    /// It isn't; what is said of it, which may be several things.
    Failed(Vec<String>),
    /// Nothing was there that could be judged.
    Idle,
    /// It wasn't looked at, and could have been.
    NotRun,
}

/// Which entries a run decides on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// Those that name rules.
    Rules,
    /// Those that name cases.
    Cases,
}

/// An entry that doesn't hold true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stale {
    /// Its number among all entries.
    pub(super) entry: usize,
    /// Why.
    pub reason: StaleReason,
}

impl Stale {
    /// Whether the list can be mended without a person. Messages that have nothing in common at their beginning can't
    /// be named by one entry: an empty beginning would excuse whatever comes.
    pub(crate) fn is_fixable(&self) -> bool {
        !matches!(&self.reason, StaleReason::FailsOtherwise { common, .. } if common.is_empty())
    }
}

/// Why an entry doesn't hold true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum StaleReason {
    /// Nothing that it names fails any more.
    Passes,
    /// Some of the cases that it names pass.
    PassesInPart {
        /// How many.
        count: usize,
        /// The first of them.
        first: String,
        /// Those that fail.
        failing: Vec<String>,
    },
    /// Something that it names fails with another message.
    FailsOtherwise {
        /// The first other message.
        found: String,
        /// What all messages have in common at their beginning.
        common: String,
    },
    /// The run has nothing that it names.
    MatchesNothing,
    /// Nothing was there that what it names could have judged.
    Idle,
    /// Its last day is over.
    Expired,
}

/// What came of all that an entry names.
#[derive(Default)]
struct Sum<'c> {
    passed: usize,
    /// The first case that passed. Of rules nobody says what passed.
    passing: Option<&'c str>,
    /// The cases that failed.
    failing: Vec<&'c str>,
    failed: usize,
    idle: usize,
    not_run: usize,
    /// The first message that the entry doesn't lead to expect.
    other: Option<String>,
    common: Option<String>,
}

impl Lists {
    /// The reason why a failure doesn't count; none where no entry names it with its messages.
    pub(crate) fn excuse(&self, name: Name<'_>, messages: &[String]) -> Option<&Excuse> {
        let excuses = |entry: &&Entry| {
            entry.names.is_match(name, true) && messages.iter().all(|message| entry.expects(message))
        };
        // What always fails is said before what may.
        let found =
            self.entries.iter().filter(excuses).min_by_key(|entry| entry.excuse.kind == ExcuseKind::Flaky);
        found.map(|entry| &entry.excuse)
    }

    /// The entries that don't hold true on the day `today`, in their order.
    pub(crate) fn find_stale(&self, scope: Scope, checked: &[Checked<'_>], today: Date) -> Vec<Stale> {
        let mut stale = Vec::new();
        let by_rule = by_rule(checked);
        for (at, entry) in self.entries.iter().enumerate() {
            let sum = match &entry.names {
                Selector::Rule { rule, .. } if scope == Scope::Rules => {
                    let of_rule = by_rule.get(rule.id).map(Vec::as_slice).unwrap_or_default();
                    Sum::new(entry, of_rule.iter().copied())
                }
                Selector::Case(_) if scope == Scope::Cases => Sum::new(entry, checked.iter()),
                Selector::Rule { .. } | Selector::Case(_) => continue,
            };
            let is_over = entry.excuse.expires.is_some_and(|last| last < today);
            let reasons =
                is_over.then_some(StaleReason::Expired).into_iter().chain(sum.reasons(entry.excuse.kind));
            stale.extend(reasons.map(|reason| Stale { entry: at, reason }));
        }
        stale
    }

    /// What is said of a stale entry.
    pub(super) fn finding(&self, stale: &Stale, level: Level) -> Option<Finding> {
        let entry = self.entries.get(stale.entry)?;
        let mut spans = entry.spans;
        if spans.selector.end - spans.selector.start > MAX_MARKED {
            spans.selector = spans.header;
        }
        let what = match &entry.names {
            Selector::Rule { .. } => "rule",
            Selector::Case(_) => "case",
        };
        let (id, span, message, help) = match &stale.reason {
            StaleReason::Passes => {
                let message = format!("nothing that this {what} names fails any more");
                ("known-passes", spans.selector, message, "remove the entry")
            }
            StaleReason::PassesInPart { count, first, failing } => {
                let all = count + failing.len();
                let message =
                    format!("{count} of the {all} cases that this names pass: the first is {first}");
                let help = "name only those that fail; what may fail or pass is flaky";
                ("known-passes", spans.selector, message, help)
            }
            StaleReason::FailsOtherwise { found, .. } => {
                let expected = entry.message.as_deref()?;
                let message = format!("it fails otherwise: expected {expected:?} and more, found {found:?}");
                let help = "look into it; where it is known too, correct the message";
                ("known-fails-otherwise", spans.message?, message, help)
            }
            StaleReason::MatchesNothing => {
                let message = format!("this {what} names nothing in this run");
                ("known-matches-nothing", spans.selector, message, "correct the pattern, or remove the entry")
            }
            StaleReason::Idle => {
                let message = format!("nothing was there to judge for this {what}");
                ("known-matches-nothing", spans.selector, message, "correct the pattern, or remove the entry")
            }
            StaleReason::Expired => {
                let message = format!("the entry expired on {}", entry.excuse.expires?);
                let help = "remove it; or, where its reason still holds, give it another date";
                ("known-expired", spans.expires?, message, help)
            }
        };
        let mut finding = Finding::new(id, level, span, message);
        finding.help(help);
        Some(finding)
    }
}

impl Selector {
    /// Whether this names something. What passes or isn't there has no subject.
    fn is_match(&self, name: Name<'_>, has_subject: bool) -> bool {
        match (self, name) {
            (Self::Rule { rule, subject, file }, Name::Rule { rule: id, subject: of, file: path }) => {
                rule.id == id.id
                    && file.as_ref().is_none_or(|file| file.is_match(path))
                    && (!has_subject || subject.as_ref().is_none_or(|subject| subject.is_match(of)))
            }
            (Self::Case(pattern), Name::Case(name)) => pattern.is_match(name),
            (Self::Rule { .. }, Name::Case(_)) | (Self::Case(_), Name::Rule { .. }) => false,
        }
    }
}

impl Entry {
    fn expects(&self, message: &str) -> bool {
        self.message.as_ref().is_none_or(|prefix| message.starts_with(prefix.as_str()))
    }
}

impl<'c> Sum<'c> {
    fn new(entry: &Entry, checked: impl Iterator<Item = &'c Checked<'c>>) -> Self {
        let mut sum = Self::default();
        for checked in checked {
            let is_failure = matches!(checked.outcome, Outcome::Failed(_));
            if entry.names.is_match(checked.name, is_failure) {
                sum.add(entry, checked);
            }
        }
        sum
    }

    fn add(&mut self, entry: &Entry, checked: &'c Checked<'c>) {
        let case = match checked.name {
            Name::Case(case) => Some(case),
            Name::Rule { .. } => None,
        };
        match &checked.outcome {
            Outcome::Passed => {
                self.passed += 1;
                self.passing = self.passing.or(case);
            }
            Outcome::Idle => self.idle += 1,
            Outcome::NotRun => self.not_run += 1,
            Outcome::Failed(messages) => {
                self.failed += 1;
                self.failing.extend(case);
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

    /// Why an entry would be stale for what doesn't fail.
    fn reason_to_remove(self, kind: ExcuseKind) -> Option<StaleReason> {
        // What wasn't run might fail.
        if self.not_run > 0 {
            return None;
        }
        match (self.failed, self.passed, self.idle) {
            (0, 0, 0) => Some(StaleReason::MatchesNothing),
            (0, 0, _) => Some(StaleReason::Idle),
            _ if kind == ExcuseKind::Flaky => None,
            (0, _, _) => Some(StaleReason::Passes),
            (_, count, _) => {
                let failing = self.failing.into_iter().map(str::to_owned).collect();
                self.passing.map(|first| StaleReason::PassesInPart {
                    count,
                    first: first.to_owned(),
                    failing,
                })
            }
        }
    }
}

/// What came of each rule: there may be many entries, and each is of one.
fn by_rule<'c, 'r>(checked: &'c [Checked<'r>]) -> BTreeMap<&'static str, Vec<&'c Checked<'r>>> {
    let mut by_rule: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for checked in checked {
        if let Name::Rule { rule, .. } = checked.name {
            by_rule.entry(rule.id).or_default().push(checked);
        }
    }
    by_rule
}
