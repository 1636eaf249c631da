//! Findings, grouped by rule and subject, with a few examples for each group.

use std::collections::{BTreeMap, btree_map};
use std::sync::Arc;

use serde::Serialize;
use uavspec_schema::source::Span;

use crate::limits::{MAX_ALL_GROUPS, MAX_GROUPS, MAX_LATEST};
use crate::{Detail, Excuse, Level, Location, Rule, SubjectName};

/// The maximum number of examples for each group.
pub const MAX_EXAMPLES: usize = 3;

/// The findings of one rule in one subject.
#[derive(Clone, Debug)]
pub struct Group {
    /// The violated rule.
    pub rule: &'static Rule,
    /// The subject: a topic with its namespace, or a field of a topic.
    pub subject: String,
    /// The instance of the topic, if the capture is a log with several instances of it.
    pub instance: Option<u8>,
    /// The number of findings.
    pub count: u64,
    /// The locations and details of the first findings.
    pub examples: Vec<(Location, Detail)>,
    /// The message that shares the shortest prefix with the first message. `None` if all messages start with the whole
    /// first message.
    pub farthest: Option<String>,
    /// The common prefix of all messages.
    prefix: String,
    /// The location of the violated definition.
    pub definition: Option<Span>,
    /// The entry of a baseline, if any.
    pub known: Option<Excuse>,
}

impl Group {
    /// The subject with the instance.
    pub fn name(&self) -> SubjectName<'_> {
        SubjectName { name: &self.subject, instance: self.instance }
    }

    /// Messages that represent all others: all messages start with a given prefix if and only if these messages do.
    pub fn messages(&self) -> Vec<String> {
        let first = self.examples.iter().map(|(_, detail)| detail.to_string());
        first.chain(self.farthest.clone()).collect()
    }

    /// True if the group has enough examples.
    fn has_examples(&self) -> bool {
        self.examples.len() >= MAX_EXAMPLES
    }

    /// Shortens the common prefix if another finding's message doesn't start with that prefix.
    fn compare(&mut self, message: String) {
        if !message.starts_with(&self.prefix) {
            let pairs = self.prefix.chars().zip(message.chars());
            let common =
                pairs.take_while(|(left, right)| left == right).map(|(left, _)| left.len_utf8()).sum();
            self.prefix.truncate(common);
            self.farthest = Some(message);
        }
    }
}

/// The result of a rule. The values are in ascending precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The rule applies to no part of the input. This verdict doesn't count as a pass.
    #[serde(rename = "not covered")]
    NotCovered,
    /// The testee doesn't support the tested operation or type. This result is neither a failure nor a pass.
    Unsupported,
    /// There are no violations.
    Pass,
    /// There are only informational findings.
    #[serde(rename = "info")]
    Shown,
    /// All violations are in a baseline.
    Known,
    /// The rule could not be checked completely.
    Inconclusive,
    /// A rule of level SHOULD is violated.
    #[serde(rename = "warning")]
    Warn,
    /// A rule of level MUST is violated.
    Fail,
}

impl Verdict {
    /// The name in all reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotCovered => "not covered",
            Self::Unsupported => "unsupported",
            Self::Pass => "pass",
            Self::Shown => "info",
            Self::Known => "known",
            Self::Inconclusive => "inconclusive",
            Self::Warn => "warning",
            Self::Fail => "fail",
        }
    }
}

/// The key of a group. Copies share the subject, because each finding needs several.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    /// The id of the rule.
    rule: &'static str,
    subject: Arc<str>,
    instance: Option<u8>,
    /// The location of the violated PX4 or ROS 2 definition. A topic of a bag may have messages of several types.
    definition: Option<Span>,
}

impl Key {
    fn new(rule: &Rule, subject: SubjectName<'_>, definition: Option<Span>) -> Self {
        let SubjectName { name, instance } = subject;
        let definition = definition.filter(|_| !rule.is_on_flockwave());
        Self { rule: rule.id, subject: name.into(), instance, definition }
    }
}

/// All findings of a run.
#[derive(Debug, Default)]
pub struct Findings {
    groups: BTreeMap<Key, Group>,
    /// The examples that were added since the last call of `complete`: the key of the group, and the index.
    incomplete: Vec<(Key, usize)>,
    /// The location of the latest findings, and the keys of their groups.
    latest: Option<(Location, Vec<Key>)>,
    /// The counts of each covered or violated rule, sorted by id so that the order of the findings doesn't matter.
    counts: Vec<(&'static Rule, Counts)>,
}

/// A violation that has been counted, and whose details are still missing.
struct Counted<'f> {
    group: &'f mut Group,
    key: Key,
    incomplete: &'f mut Vec<(Key, usize)>,
    location: Location,
}

impl Counted<'_> {
    /// Adds the details.
    fn describe(self, detail: Detail) {
        let Self { group, key, incomplete, location } = self;
        if group.count == 1 {
            group.prefix = detail.to_string();
        } else {
            group.compare(detail.to_string());
        }
        if !group.has_examples() {
            incomplete.push((key, group.examples.len()));
            group.examples.push((location, detail));
        }
    }
}

/// The counts of a rule.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// The number of groups.
    num_groups: usize,
    /// The number of items that the rule checked.
    covered: u64,
    /// The number of findings that have no group because there were too many groups.
    dropped: u64,
}

impl Findings {
    /// Adds to the number of items that a rule checked.
    pub fn cover(&mut self, rule: &'static Rule, times: u64) {
        counts_of(&mut self.counts, rule).covered += times;
    }

    /// Reports a violation of a rule in `subject`.
    pub fn report<'s>(
        &mut self,
        rule: &'static Rule,
        subject: impl Into<SubjectName<'s>>,
        location: Location,
        definition: Option<Span>,
        detail: impl FnOnce() -> Detail,
    ) {
        if let Some(found) = self.count_violation(rule, subject.into(), location, definition) {
            found.describe(detail());
        }
    }

    /// Counts a violation of a rule in `subject`. Returns `None` if its details are not needed.
    ///
    /// The compiler copies `report` for each of its many callers, so all code that doesn't depend on the caller is
    /// here.
    fn count_violation(
        &mut self,
        rule: &'static Rule,
        subject: SubjectName<'_>,
        location: Location,
        definition: Option<Span>,
    ) -> Option<Counted<'_>> {
        let key = Key::new(rule, subject, definition);
        let is_full = self.groups.len() >= MAX_ALL_GROUPS;
        let group = match self.groups.entry(key.clone()) {
            btree_map::Entry::Occupied(known) => known.into_mut(),
            btree_map::Entry::Vacant(new) => {
                let counts = counts_of(&mut self.counts, rule);
                if is_full || counts.num_groups >= MAX_GROUPS {
                    counts.dropped += 1;
                    return None;
                }
                counts.num_groups += 1;
                new.insert(Group {
                    rule,
                    subject: subject.name.to_owned(),
                    instance: key.instance,
                    count: 0,
                    examples: Vec::new(),
                    farthest: None,
                    prefix: String::new(),
                    definition,
                    known: None,
                })
            }
        };
        group.count += 1;
        match &mut self.latest {
            Some((latest, keys)) if *latest == location => {
                if keys.len() < MAX_LATEST {
                    keys.push(key.clone());
                }
            }
            latest => *latest = Some((location, vec![key.clone()])),
        }
        // An empty common prefix can't get shorter.
        if group.has_examples() && group.prefix.is_empty() {
            return None;
        }
        Some(Counted { group, key, incomplete: &mut self.incomplete, location })
    }

    /// Removes the findings in a record, if they are the latest findings.
    pub fn retract(&mut self, location: Location) {
        let Some((_, keys)) = self.latest.take_if(|(latest, _)| *latest == location) else { return };
        for key in keys {
            self.remove_from(&key, 1, &[location]);
        }
    }

    /// Removes findings of a rule in `subject`: their number, and the locations of the first ones.
    pub fn remove(
        &mut self,
        rule: &'static Rule,
        subject: SubjectName<'_>,
        definition: Option<Span>,
        (count, examples): (u64, &[Location]),
    ) {
        self.remove_from(&Key::new(rule, subject, definition), count, examples);
    }

    fn remove_from(&mut self, key: &Key, count: u64, examples: &[Location]) {
        let Some(group) = self.groups.get_mut(key) else { return };
        group.count = group.count.saturating_sub(count);
        group.examples.retain(|(found, _)| !examples.contains(found));
        if group.count == 0 {
            let rule = group.rule;
            self.groups.remove(key);
            counts_of(&mut self.counts, rule).num_groups -= 1;
        }
    }

    /// Changes the details of an earlier finding, if it is one of its group's stored examples.
    pub fn amend(
        &mut self,
        rule: &Rule,
        subject: &str,
        location: Location,
        change: impl FnOnce(&mut Detail),
    ) {
        let group = self.groups.get_mut(&Key::new(rule, subject.into(), None));
        let mut examples = group.into_iter().flat_map(|group| &mut group.examples);
        if let Some((_, detail)) = examples.find(|(found, _)| *found == location) {
            change(detail);
        }
    }

    /// Removes the instance from the groups of topics that have only their first instance.
    pub fn hide_only_instances(&mut self, is_only: impl Fn(&str) -> bool) {
        for group in self.groups.values_mut().filter(|group| group.instance == Some(0)) {
            let topic = group.subject.split('.').next().unwrap_or_default();
            group.instance = group.instance.filter(|_| !is_only(topic));
        }
    }

    /// Forgets which findings are the latest, at the end of the capture.
    pub fn close(&mut self) {
        self.latest = None;
        self.incomplete.clear();
    }

    /// Completes the details of the findings in a record that has just been checked. Findings in earlier records are
    /// unchanged.
    #[inline]
    pub fn complete(&mut self, location: Location, complete: impl Fn(&mut Detail)) {
        if !self.incomplete.is_empty() {
            self.complete_all(location, complete);
        }
    }

    #[cold]
    fn complete_all(&mut self, location: Location, complete: impl Fn(&mut Detail)) {
        for (key, at) in self.incomplete.drain(..) {
            let example = self.groups.get_mut(&key).and_then(|group| group.examples.get_mut(at));
            if let Some((_, detail)) = example.filter(|(found, _)| *found == location) {
                complete(detail);
            }
        }
    }

    /// Removes the findings and counts of all rules that don't satisfy a predicate.
    pub fn retain(&mut self, is_kept: impl Fn(&Rule) -> bool) {
        self.groups.retain(|_, group| is_kept(group.rule));
        self.counts.retain(|(rule, _)| is_kept(rule));
    }

    /// True if a group of a session has enough examples, so further findings are only counted.
    pub fn has_examples(&self, rule: &Rule, subject: &str) -> bool {
        self.groups.get(&Key::new(rule, subject.into(), None)).is_some_and(Group::has_examples)
    }

    /// Ends the comparison of the messages in a group, so that further findings are only counted. A baseline can then
    /// no longer rely on a common prefix of all messages. Returns false if there is no such group.
    pub fn settle(&mut self, rule: &Rule, subject: SubjectName<'_>, definition: Option<Span>) -> bool {
        let group = self.groups.get_mut(&Key::new(rule, subject, definition));
        group.map(|group| group.compare(String::new())).is_some()
    }

    /// Counts further findings in a group that has enough examples.
    pub fn count<'s>(
        &mut self,
        rule: &Rule,
        subject: impl Into<SubjectName<'s>>,
        definition: Option<Span>,
        times: u64,
    ) {
        if let Some(group) = self.groups.get_mut(&Key::new(rule, subject.into(), definition)) {
            group.count += times;
        }
    }

    /// All groups, sorted by rule and subject.
    pub fn groups(&self) -> impl Iterator<Item = &Group> {
        self.groups.values()
    }

    /// The groups of a rule.
    pub fn groups_of(&self, rule: &'static Rule) -> impl Iterator<Item = &Group> {
        let first = Key::new(rule, "".into(), None);
        self.groups.range(first..).map(|(_, group)| group).take_while(|group| group.rule.id == rule.id)
    }

    /// The number of a rule's findings that have no group.
    pub fn dropped(&self, rule: &Rule) -> u64 {
        self.known_counts_of(rule).map_or(0, |counts| counts.dropped)
    }

    /// The number of items that a rule checked.
    pub fn covered(&self, rule: &Rule) -> u64 {
        // If there is a finding, at least one item was checked.
        let is_violated = |counts: &Counts| counts.num_groups > 0 || counts.dropped > 0;
        self.known_counts_of(rule).map_or(0, |counts| counts.covered.max(u64::from(is_violated(counts))))
    }

    /// The counts of a covered or violated rule. The lookup happens for each message, so it compares addresses, which
    /// is faster than comparing ids.
    fn known_counts_of(&self, rule: &Rule) -> Option<&Counts> {
        self.counts.iter().find(|(known, _)| std::ptr::eq(*known, rule)).map(|(_, counts)| counts)
    }

    /// Marks the groups for which `excuse` returns a known failure.
    pub fn excuse(&mut self, mut excuse: impl FnMut(&Group) -> Option<Excuse>) {
        self.groups.values_mut().for_each(|group| group.known = excuse(group));
    }

    /// The verdict of a rule. Findings without a group never count as known.
    pub fn verdict(&self, rule: &'static Rule) -> Verdict {
        let is_dropped = self.dropped(rule) > 0;
        let is_known = !is_dropped && self.groups_of(rule).all(|group| group.known.is_some());
        match (is_dropped || self.groups_of(rule).next().is_some(), rule.level) {
            (true, _) if is_known => Verdict::Known,
            (true, Level::Must) => Verdict::Fail,
            (true, Level::Should) => Verdict::Warn,
            (true, Level::Info) => Verdict::Shown,
            (false, _) if self.covered(rule) == 0 => Verdict::NotCovered,
            (false, _) => Verdict::Pass,
        }
    }
}

/// The counts of a rule. They are created with zeros if the rule has none yet.
fn counts_of<'c>(counts: &'c mut Vec<(&'static Rule, Counts)>, rule: &'static Rule) -> &'c mut Counts {
    let at = counts.iter().position(|(known, _)| std::ptr::eq(*known, rule));
    let at = at.unwrap_or_else(|| {
        let at = counts.partition_point(|(known, _)| known.id < rule.id);
        counts.insert(at, (rule, Counts::default()));
        at
    });
    &mut counts[at].1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;

    /// A rule that must not be violated.
    const fn rule(id: &'static str) -> Rule {
        Rule {
            id,
            name: "Glider",
            level: Level::Must,
            status: Status::Normative,
            statement: "A glider is right.",
            source: "",
            applies_to: "gliders",
            why: "",
            example: "",
            fix: "",
        }
    }

    static RULES: [Rule; 12] = [
        rule("SKY-01"),
        rule("SKY-02"),
        rule("SKY-03"),
        rule("SKY-04"),
        rule("SKY-05"),
        rule("SKY-06"),
        rule("SKY-07"),
        rule("SKY-08"),
        rule("SKY-09"),
        rule("SKY-10"),
        rule("SKY-11"),
        rule("SKY-12"),
    ];

    fn reported(messages: &[&str]) -> Findings {
        let mut findings = Findings::default();
        for (line, message) in (1..).zip(messages) {
            findings
                .report(&RULES[0], "glider.is_landed", Location::Line(line), None, || Detail::new(*message));
        }
        findings
    }

    fn messages_of(findings: &Findings) -> Vec<String> {
        findings.groups().flat_map(Group::messages).collect()
    }

    /// The closure that creates the text runs only before the group is settled.
    #[test]
    fn findings_of_a_settled_group_are_only_counted() {
        let rule = &RULES[0];
        let mut findings = reported(&["odd 2", "odd 3", "odd 4"]);
        let mut described = 0;
        let mut report = |findings: &mut Findings| {
            findings.report(rule, "glider.is_landed", Location::Line(9), None, || {
                described += 1;
                Detail::new("odd 5")
            });
        };
        report(&mut findings);
        assert!(findings.settle(rule, "glider.is_landed".into(), None));
        (0..10_000).for_each(|_| report(&mut findings));
        findings.count(rule, "glider.is_landed", None, 7);
        assert_eq!((described, findings.groups().map(|group| group.count).sum::<u64>()), (1, 10_011));
        // The messages have no common prefix, because the messages of the counted findings are unknown.
        assert_eq!(messages_of(&findings), ["odd 2", "odd 3", "odd 4", ""]);
        assert!(!findings.settle(rule, "glider.mode".into(), None));
    }

    #[test]
    fn the_number_of_groups_is_limited_and_no_violation_is_lost() {
        let mut findings = Findings::default();
        for (rule, number) in RULES.iter().flat_map(|rule| (0..6_000).map(move |number| (rule, number))) {
            findings.report(rule, &format!("topic{number}"), Location::Line(1), None, || Detail::new("odd"));
        }
        assert_eq!(findings.groups().count(), MAX_ALL_GROUPS);
        for rule in &RULES {
            assert_eq!(findings.verdict(rule), Verdict::Fail, "{}", rule.id);
            assert_eq!(findings.groups_of(rule).count() as u64 + findings.dropped(rule), 6_000);
            assert_eq!(findings.covered(rule), 1);
        }
    }

    #[test]
    fn messages_represent_those_without_an_example() {
        let odd = ["153 is no bool", "153 is no bool", "153 is no bool", "15 is no bool", "94 is no bool"];
        assert_eq!(messages_of(&reported(&odd[..3])), odd[..3]);
        for all in [&odd[..4], &odd] {
            let findings = reported(all);
            let messages = messages_of(&findings);
            assert_eq!(messages.last().map(String::as_str), all.last().copied());
            for start in ["153", "15", "1", "94", ""] {
                let begin = |messages: &[&str]| messages.iter().all(|message| message.starts_with(start));
                let reported: Vec<&str> = messages.iter().map(String::as_str).collect();
                assert_eq!(begin(&reported), begin(all), "{start} of {all:?}");
            }
            assert_eq!(findings.groups().map(|group| group.count).sum::<u64>(), all.len() as u64);
        }
    }
}
