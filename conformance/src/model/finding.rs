//! What was found, counted: equal findings are one, with the places of the first few.

use std::collections::BTreeMap;

use uavspec_codegen::source::Span;

use crate::model::{Detail, Excuse, Level, Location, Rule};

/// How many places of equal findings are kept.
const MAX_EXAMPLES: usize = 3;

/// How many different findings are kept of a rule: hostile input can have any number.
const MAX_GROUPS: usize = 1_000;

/// Equal findings: of one rule, in one subject.
#[derive(Clone, Debug)]
pub struct Group {
    /// The rule that is broken.
    pub rule: &'static Rule,
    /// What breaks it: a topic, or a field of one.
    pub subject: String,
    /// How often.
    pub count: u64,
    /// The first of them: where, and what was found there.
    pub examples: Vec<(Location, Detail)>,
    /// The message that has the least in common with the first one, at their beginnings; none where all are as that.
    pub farthest: Option<String>,
    /// How much all messages have in common at their beginnings, in bytes.
    common: usize,
    /// Where the definition says what should be.
    pub definition: Option<Span>,
    /// Why it is let stand, where a list of known failures says so.
    pub known: Option<Excuse>,
}

impl Group {
    /// Messages that stand for all: whether these begin with a text, tells whether all do.
    pub fn messages(&self) -> Vec<String> {
        let first = self.examples.iter().map(|(_, detail)| detail.to_string());
        first.chain(self.farthest.clone()).collect()
    }

    /// Looks at a message of one more finding, which stands not yet among the examples.
    fn compare(&mut self, message: String) {
        let first = self.examples.first().map_or_else(|| message.clone(), |(_, detail)| detail.to_string());
        let pairs = first.chars().zip(message.chars());
        let common = pairs.take_while(|(left, right)| left == right).map(|(left, _)| left.len_utf8()).sum();
        // Where the whole of the first message begins all others, these are expected wherever it is.
        if common < self.common {
            self.common = common;
            self.farthest = (common < first.len()).then_some(message);
        }
    }
}

/// What came of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing breaks it.
    Pass,
    /// Something breaks it, and it should be looked at.
    Warn,
    /// Something breaks it that must not.
    Fail,
    /// All that breaks it is listed as known.
    Known,
    /// It is broken, or rather shown: it judges nothing.
    Shown,
    /// Nothing was there that it could have judged.
    NotCovered,
}

/// All findings of a run.
#[derive(Debug, Default)]
pub struct Findings {
    groups: BTreeMap<(&'static str, String), Group>,
    /// The counts of each rule that was exercised or violated, by id: findings are equal in whatever order they came.
    counts: Vec<(&'static Rule, Counts)>,
}

/// What is counted of a rule.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// How many groups it has.
    num_groups: usize,
    /// How often it was exercised.
    covered: u64,
    /// How many findings belong to no group, as there are too many.
    dropped: u64,
}

impl Findings {
    /// A rule was exercised so often.
    pub(crate) fn cover(&mut self, rule: &'static Rule, times: u64) {
        self.counts_of(rule).covered += times;
    }

    /// Something in `subject` breaks a rule.
    pub(crate) fn report(
        &mut self,
        rule: &'static Rule,
        subject: &str,
        location: Location,
        definition: Option<Span>,
        detail: impl FnOnce() -> Detail,
    ) {
        let key = (rule.id, subject.to_owned());
        if !self.groups.contains_key(&key) {
            let counts = self.counts_of(rule);
            if counts.num_groups >= MAX_GROUPS {
                counts.dropped += 1;
                return;
            }
            counts.num_groups += 1;
        }
        let group = self.groups.entry(key).or_insert_with(|| Group {
            rule,
            subject: subject.to_owned(),
            count: 0,
            examples: Vec::new(),
            farthest: None,
            common: usize::MAX,
            definition,
            known: None,
        });
        group.count += 1;
        let has_examples = group.examples.len() >= MAX_EXAMPLES;
        // Messages that have nothing in common can't have less.
        if has_examples && group.common == 0 {
            return;
        }
        let detail = detail();
        group.compare(detail.to_string());
        if !has_examples {
            group.examples.push((location, detail));
        }
    }

    /// Whether a further finding of a rule in `subject` would only be counted: there are examples enough.
    pub(crate) fn has_examples(&self, rule: &Rule, subject: &str) -> bool {
        let group = self.groups.get(&(rule.id, subject.to_owned()));
        group.is_some_and(|group| group.examples.len() == MAX_EXAMPLES)
    }

    /// Counts so many more findings of a rule in `subject`, of which there are examples enough.
    pub(crate) fn count(&mut self, rule: &Rule, subject: &str, times: u64) {
        if let Some(group) = self.groups.get_mut(&(rule.id, subject.to_owned())) {
            group.count += times;
        }
    }

    /// All groups, by rule and subject.
    pub fn groups(&self) -> impl Iterator<Item = &Group> {
        self.groups.values()
    }

    /// The groups of a rule.
    pub fn groups_of(&self, rule: &'static Rule) -> impl Iterator<Item = &Group> {
        let first = (rule.id, String::new());
        self.groups.range(first..).map(|(_, group)| group).take_while(|group| group.rule.id == rule.id)
    }

    /// How many findings of a rule are in no group.
    pub fn dropped(&self, rule: &Rule) -> u64 {
        self.known_counts_of(rule).map_or(0, |counts| counts.dropped)
    }

    /// How often a rule was exercised.
    pub fn covered(&self, rule: &Rule) -> u64 {
        // A finding says that there was something to judge.
        self.known_counts_of(rule).map_or(0, |counts| counts.covered.max(u64::from(counts.num_groups > 0)))
    }

    /// The counts of a rule that was exercised or violated. They are looked up with each message, and an address is
    /// compared faster than an id.
    fn known_counts_of(&self, rule: &Rule) -> Option<&Counts> {
        self.counts.iter().find(|(known, _)| std::ptr::eq(*known, rule)).map(|(_, counts)| counts)
    }

    /// The counts of a rule, which start at zero.
    fn counts_of(&mut self, rule: &'static Rule) -> &mut Counts {
        let at = self.counts.iter().position(|(known, _)| std::ptr::eq(*known, rule));
        let at = at.unwrap_or_else(|| {
            let at = self.counts.partition_point(|(known, _)| known.id < rule.id);
            self.counts.insert(at, (rule, Counts::default()));
            at
        });
        &mut self.counts[at].1
    }

    /// Notes at each group why it is let stand, where `excuse` says so.
    pub(crate) fn excuse(&mut self, mut excuse: impl FnMut(&Group) -> Option<Excuse>) {
        self.groups.values_mut().for_each(|group| group.known = excuse(group));
    }

    /// What came of a rule. What was too much to be kept can't be told to be known.
    pub fn verdict(&self, rule: &'static Rule) -> Verdict {
        let is_known = self.dropped(rule) == 0 && self.groups_of(rule).all(|group| group.known.is_some());
        match (self.groups_of(rule).next().is_some(), rule.level) {
            (true, _) if is_known => Verdict::Known,
            (true, Level::Must) => Verdict::Fail,
            (true, Level::Should) => Verdict::Warn,
            (true, Level::Info) => Verdict::Shown,
            (false, _) if self.covered(rule) == 0 => Verdict::NotCovered,
            (false, _) => Verdict::Pass,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::rule;

    fn reported(messages: &[&str]) -> Findings {
        let mut findings = Findings::default();
        for (line, message) in (1..).zip(messages) {
            let rule = rule("PX-BOOL-01").expect("a rule");
            findings.report(rule, "glider.is_landed", Location::Line(line), None, || Detail::new(*message));
        }
        findings
    }

    fn messages_of(findings: &Findings) -> Vec<String> {
        findings.groups().flat_map(Group::messages).collect()
    }

    #[test]
    fn a_message_that_is_no_example_is_not_forgotten() {
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
