//! Finds the entries of a list that are stale after a run.

use std::collections::BTreeMap;

use uavspec_schema::Date;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::{Edit, Finding};
use uavspec_schema::wording::plural;

use super::edit::quote;
use super::pattern::exact;
use super::{Entry, Lists, Name};

/// The maximum length, in bytes, of a pattern that is underlined in full in messages. Automatic fixes may write
/// patterns of any length.
const MAX_MARKED: u32 = 200;

/// The maximum length of a `message` value that a fix writes, in characters. A longer text would become stale more
/// often.
const MAX_MESSAGE: usize = 120;

/// The result of a case, or of a rule for a subject in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Passed. A rule gets this result for each file in which it checked anything. The rule's findings in that file are
    /// separate results.
    Passed,
    /// Failed, with these messages. For a rule of `lint` or `breaking`, each message is a finding.
    Failed(Vec<String>),
    /// There was nothing to check.
    Idle,
    /// Not run, so it might fail.
    NotRun,
}

/// Selects the entries that a run can detect as stale, by the rule of the entry. Entries about cases have no rule.
pub type Scope<'s> = &'s dyn Fn(Option<&str>) -> bool;

/// The results of a run, counted for each entry within the scope. The results themselves aren't kept.
#[derive(Debug)]
pub struct Sums(BTreeMap<usize, Sum>);

/// The counts and messages of all results that an entry matches.
#[derive(Debug, Default)]
struct Sum {
    passed: usize,
    /// The first case that passed; `None` for rules.
    passing: Option<String>,
    /// The cases that failed.
    failing: Vec<String>,
    /// The number of findings. If the entry has a count, findings that another entry covers are not counted.
    failed: usize,
    idle: usize,
    not_run: usize,
    /// The first unexpected message.
    other: Option<String>,
    /// The common prefix of all messages.
    common: Option<String>,
}

impl Lists {
    /// Starts counting results.
    pub fn sums(&self, scope: Scope<'_>) -> Sums {
        let entries = self.entries.iter().enumerate();
        let entries = entries.filter(|(_, entry)| scope(entry.rule.as_deref()));
        Sums(entries.map(|(at, _)| (at, Sum::default())).collect())
    }

    /// Counts a result for each entry that it matches.
    pub fn count(&self, sums: &mut Sums, name: &Name<'_>, outcome: &Outcome) {
        let matching = self.matching(name);
        let covering = match outcome {
            Outcome::Failed(messages) => self.covering(&matching, messages),
            Outcome::Passed | Outcome::Idle | Outcome::NotRun => None,
        };
        for at in &matching {
            if let Some(sum) = sums.0.get_mut(at) {
                sum.add(&self.entries[*at], name, outcome, covering == Some(*at));
            }
        }
    }

    /// The findings about entries that are stale on `today`, in order. Each fix is an edit of the list. There is no fix
    /// if messages have no common prefix, because an empty prefix would match any failure. An entry with more findings
    /// than its count is reported as a note.
    pub fn stale(&self, sums: &Sums, today: Date) -> Vec<Finding> {
        sums.0.iter().flat_map(|(at, sum)| self.reasons(*at, sum, today)).collect()
    }

    /// The reasons why an entry is stale.
    fn reasons(&self, at: usize, sum: &Sum, today: Date) -> Vec<Finding> {
        let entry = &self.entries[at];
        let spans = entry.spans;
        let is_long = spans.name.end - spans.name.start > MAX_MARKED;
        let name = if is_long { spans.header } else { spans.name };
        let noun = match (&entry.rule, &entry.name) {
            (None, _) => "case".to_owned(),
            (Some(_), None) => "rule".to_owned(),
            (Some(rule), Some(_)) => format!("subject of `{rule}`"),
        };
        let mut findings = Vec::new();
        let mut report = |id, level, span, message, help: &str, fix: Option<Edit>| {
            let mut finding = Finding::new(id, level, span, message);
            finding.help(help).fix.extend(fix);
            findings.push(finding);
        };
        let removal = || Some(self.removal(at));
        let set = |span, text| Some(Edit { span, text });
        if let Some((last, span)) = entry.expires.zip(spans.expires).filter(|(last, _)| *last < today) {
            let message = format!("the entry expired on {last}");
            let help = "remove the entry, or set a later date if the reason still applies";
            report("baseline-expired", Level::Error, span, message, help, removal());
        }
        if let (Some(found), Some(expected), Some(span), false) =
            (&sum.other, &entry.message, spans.message, entry.is_flaky)
        {
            let message = format!("the message differs: expected {expected:?} at the start, found {found:?}");
            let help = "investigate the failure; if the new failure is known too, update the message";
            let common: String =
                sum.common.iter().flat_map(|common| common.chars()).take(MAX_MESSAGE).collect();
            let fix = if common.is_empty() { None } else { set(span, quote(&common)) };
            report("baseline-fails-otherwise", Level::Error, span, message, help, fix);
        }
        // A case that wasn't run might fail, so don't report its entry as stale.
        if sum.not_run > 0 {
            return findings;
        }
        let unmatched = "correct the pattern, or remove the entry";
        match (sum.failed, sum.passed, sum.idle) {
            (0, 0, 0) => {
                let message = format!("nothing in this run matches this {noun}");
                report("baseline-unmatched", Level::Error, name, message, unmatched, removal());
            }
            (0, 0, _) => {
                let message = format!("there was nothing to check for this {noun}");
                report("baseline-unmatched", Level::Error, name, message, unmatched, removal());
            }
            (0, _, _) if !entry.is_flaky => {
                let message = format!("this {noun} matches only passing results");
                report("baseline-passes", Level::Error, name, message, "remove the entry", removal());
            }
            (found, passed, _) => {
                if let (Some(first), false) = (&sum.passing, entry.is_flaky) {
                    let all = passed + sum.failing.len();
                    let message = format!("{passed} of {all} matching cases pass; the first is {first}");
                    let help =
                        "match only the cases that fail; use `[[flaky]]` for cases that sometimes pass";
                    let fix = set(spans.name, quote(&exact(&sum.failing)));
                    report("baseline-passes", Level::Error, name, message, help, fix);
                }
                if let (Some(count), Some(span)) = (entry.count, spans.count)
                    && (found > count || found < count && !entry.is_flaky)
                {
                    let (level, help) = if found > count {
                        (Level::Note, "all are reported, because it is unknown which of them are new")
                    } else {
                        (Level::Error, "update the count")
                    };
                    let message = format!("this {noun} has {} instead of {count}", plural(found, "finding"));
                    report("baseline-count", level, span, message, help, set(span, found.to_string()));
                }
            }
        }
        findings
    }

    /// The findings about entries that are stale after a run with these results.
    pub fn find_stale(&self, scope: Scope<'_>, results: &[(Name<'_>, Outcome)], today: Date) -> Vec<Finding> {
        let mut sums = self.sums(scope);
        for (name, outcome) in results {
            self.count(&mut sums, name, outcome);
        }
        self.stale(&sums, today)
    }

    /// Ends a run: entries with more findings than their count cover none of them from now on.
    pub fn limit(&mut self, sums: &Sums) {
        for (at, sum) in &sums.0 {
            let entry = &mut self.entries[*at];
            entry.is_exceeded = entry.count.is_some_and(|count| sum.failed > count);
        }
    }
}

impl Sum {
    fn add(&mut self, entry: &Entry, name: &Name<'_>, outcome: &Outcome, is_covering: bool) {
        let case = name.forms.first().filter(|_| name.rule.is_none()).map(|case| case.clone().into_owned());
        match outcome {
            Outcome::Passed => {
                self.passed += 1;
                self.passing = self.passing.take().or(case);
            }
            Outcome::Idle => self.idle += 1,
            Outcome::NotRun => self.not_run += 1,
            Outcome::Failed(_) if entry.count.is_some() && !is_covering => {}
            Outcome::Failed(messages) => {
                self.failed += messages.len().max(1);
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
}
