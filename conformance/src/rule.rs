//! The rules, a file each, and the one list of all.
//!
//! A rule is a statement with a permanent id. Rules on single values are checked by a plan that is made once
//! for each format ([`crate::plan`], and for JSON [`crate::json`]); rules on the course of things keep a state of their own ([`Checker`]).

mod px_arr_01;
mod px_bool_01;
mod px_cdr_01;
mod px_cdr_02;
mod px_data_01;
mod px_data_02;
mod px_data_03;
mod px_enum_01;
mod px_ext;
mod px_ext_01;
mod px_ext_02;
mod px_ext_03;
mod px_ext_04;
mod px_ext_05;
mod px_fmt_01;
mod px_fmt_02;
mod px_fmt_03;
mod px_fsf_03;
mod px_hash_01;
mod px_json_01;
mod px_json_02;
mod px_len_01;
mod px_nan_01;
mod px_queue_01;
mod px_range_01;
mod px_str_01;
mod px_time_01;
mod px_time_02;
mod px_ver_01;

use std::fmt;

use serde::Serialize;

use crate::definitions::Definitions;
use crate::detail::Detail;
use crate::finding::Findings;
use crate::record::{Channel, Message, Place};
use crate::sample::Flight;

/// Every rule, by id.
pub static RULES: [&Rule; 28] = [
    &px_arr_01::RULE,
    &px_bool_01::RULE,
    &px_cdr_01::RULE,
    &px_cdr_02::RULE,
    &px_data_01::RULE,
    &px_data_02::RULE,
    &px_data_03::RULE,
    &px_enum_01::RULE,
    &px_ext_01::RULE,
    &px_ext_02::RULE,
    &px_ext_03::RULE,
    &px_ext_04::RULE,
    &px_ext_05::RULE,
    &px_fmt_01::RULE,
    &px_fmt_02::RULE,
    &px_fmt_03::RULE,
    &px_fsf_03::RULE,
    &px_hash_01::RULE,
    &px_json_01::RULE,
    &px_json_02::RULE,
    &px_len_01::RULE,
    &px_nan_01::RULE,
    &px_queue_01::RULE,
    &px_range_01::RULE,
    &px_str_01::RULE,
    &px_time_01::RULE,
    &px_time_02::RULE,
    &px_ver_01::RULE,
];

/// How much a rule binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "UPPERCASE")]
pub enum Level {
    /// Derived, and shown without being judged.
    Info,
    /// What breaks it should be looked at.
    Should,
    /// What breaks it doesn't conform.
    Must,
}

impl fmt::Display for Level {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Info => "INFO",
            Self::Should => "SHOULD",
            Self::Must => "MUST",
        })
    }
}

/// Whether what a rule says is beyond doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The specification lays it down.
    Normative,
    /// The specification contradicts itself; how, says the text.
    Disputed(&'static str),
    /// It follows from the specification, or from what it is for.
    Advisory,
}

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Normative => "normative",
            Self::Disputed(_) => "disputed",
            Self::Advisory => "advisory",
        })
    }
}

/// A rule.
#[derive(Debug)]
pub struct Rule {
    /// Its id, which never changes its meaning and is never used again.
    pub id: &'static str,
    /// How much it binds.
    pub level: Level,
    /// Whether it is beyond doubt.
    pub status: Status,
    /// What has to hold.
    pub statement: &'static str,
    /// What lays it down.
    pub source: &'static str,
    /// What it is about.
    pub applies_to: &'static str,
    /// What finds breaches.
    pub check: Check,
    /// What it has to find.
    pub mutants: &'static [Mutant],
}

/// What finds breaches of a rule.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// The plan of a format, value by value.
    Value,
    /// Whoever reads the source, since what breaks it can't be read as anything.
    Source,
    /// A state that follows the records of a source.
    State(fn() -> Box<dyn Checker>),
}

/// A source that breaks a rule: a small change of one that conforms.
#[derive(Debug)]
pub struct Mutant {
    /// What is changed.
    pub name: &'static str,
    /// Makes it of a flight; none where the definitions have nothing that could be changed so.
    pub make: fn(&Flight<'_>) -> Option<Vec<u8>>,
    /// The ids of other rules that it can't but break, too.
    pub also: &'static [&'static str],
}

/// What a rule wants to know of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interest {
    /// No more than that it was opened.
    #[default]
    Nothing,
    /// When messages come.
    Times,
    /// What they say.
    Values,
}

/// Follows the records of one source.
pub trait Checker {
    /// A channel is opened: a topic with its type. Only messages of channels that are of interest come.
    fn opened(&mut self, channel: &Channel<'_>, judged: &mut Judged<'_>) -> Interest;

    /// A message comes.
    fn message(&mut self, _channel: &Channel<'_>, _message: &Message<'_>, _judged: &mut Judged<'_>) {}

    /// Records were lost, for so many milliseconds.
    fn dropout(&mut self, _milliseconds: u16, _place: Place) {}

    /// Something can't be read, and records may be lost with it.
    fn damage(&mut self, _place: Place) {}

    /// The source ends.
    fn end(&mut self, _judged: &mut Judged<'_>) {}
}

/// A state for each channel.
#[derive(Debug)]
struct PerChannel<T>(Vec<T>);

impl<T: Default + Clone> PerChannel<T> {
    /// Starts anew with a channel.
    fn open(&mut self, channel: &Channel<'_>, state: T) {
        let count = self.0.len().max(channel.index + 1);
        self.0.resize(count, T::default());
        self.0[channel.index] = state;
    }

    /// The state of a channel that was opened.
    fn of(&mut self, channel: &Channel<'_>) -> Option<&mut T> {
        self.0.get_mut(channel.index)
    }
}

impl<T> Default for PerChannel<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

/// Where a rule puts what it finds.
pub struct Judged<'j> {
    /// The rule.
    pub rule: &'static Rule,
    /// What it is judged by.
    pub definitions: &'j Definitions,
    /// All findings.
    pub findings: &'j mut Findings,
    /// How often it was exercised.
    pub exercised: &'j mut u64,
}

impl Judged<'_> {
    /// Something was looked at, whatever came of it.
    pub fn exercise(&mut self) {
        *self.exercised += 1;
    }

    /// Something breaks the rule.
    pub fn report(&mut self, subject: &str, place: Place, detail: impl FnOnce() -> Detail) {
        self.findings.report(self.rule, subject, place, None, detail);
    }
}

// A rule that finds nothing is none.
const _: () = assert!(have_mutants(&RULES), "a rule without a mutant");

/// Whether each of these rules has a mutant.
const fn have_mutants(rules: &[&Rule]) -> bool {
    match rules {
        [] => true,
        [first, rest @ ..] => !first.mutants.is_empty() && have_mutants(rest),
    }
}

/// The rule of an id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_so_that_they_can_be_looked_up() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }

    #[test]
    fn a_rule_without_a_mutant_is_seen_among_others() {
        let without = Rule { check: Check::Value, mutants: &[], ..px_arr_01::RULE };
        assert!(have_mutants(&RULES));
        assert!(!have_mutants(&[&px_arr_01::RULE, &without, &px_bool_01::RULE]));
    }

    #[test]
    fn levels_and_statuses_are_words_that_keep_to_columns() {
        let levels = [Level::Info, Level::Should, Level::Must].map(|level| format!("{level:7}|"));
        assert_eq!(levels, ["INFO   |", "SHOULD |", "MUST   |"]);
        let statuses = [Status::Normative, Status::Disputed("how"), Status::Advisory];
        assert_eq!(statuses.map(|status| status.to_string()), ["normative", "disputed", "advisory"]);
    }
}
