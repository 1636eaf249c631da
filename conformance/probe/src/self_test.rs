//! Checks all mutants, and compares the violated rules with the expected rules.

pub mod live;
pub mod vehicle;

use std::collections::BTreeSet;

use uavspec_check::{CaptureResult, check_capture};
use uavspec_model::Rule;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::sample::{Encoding, Flight};
use uavspec_rules::{Mutant, RULES, mutants};

/// The result for a mutant.
#[derive(Debug)]
pub struct Row {
    /// The rule that the mutant violates.
    pub rule: &'static Rule,
    /// The mutant.
    pub mutant: Mutant,
    /// The name of the mutant; for PX4 rules, followed by the capture's encoding.
    pub title: String,
    /// The ids of the violated rules. `None` if the definitions don't allow the mutant.
    pub violated: Option<BTreeSet<&'static str>>,
}

impl Row {
    /// The ids of the rules that the mutant should violate.
    pub fn expected(&self) -> BTreeSet<&'static str> {
        self.mutant.also.iter().chain([&self.rule]).map(|rule| rule.id).collect()
    }

    /// True if exactly the expected rules are violated, or if the mutant couldn't be created.
    pub fn is_right(&self) -> bool {
        self.violated.as_ref().is_none_or(|violated| *violated == self.expected())
    }
}

/// The rules that were violated in a probe and in its recording.
#[derive(Debug)]
pub struct Found {
    /// The violated rules.
    violated: BTreeSet<&'static str>,
    /// The rules that the recording violates.
    recorded: BTreeSet<&'static str>,
    /// The covered rules.
    pub covered: BTreeSet<&'static str>,
    /// The reason why the probe ended early.
    failure: Option<String>,
}

impl Found {
    fn new(live: &CaptureResult, recorded: &CaptureResult, failure: Option<String>) -> Self {
        let is_covered = |rule: &&&'static Rule| live.findings.covered(rule) > 0;
        let covered = RULES.iter().filter(is_covered).map(|rule| rule.id).collect();
        Self { violated: violated(live), recorded: violated(recorded), covered, failure }
    }

    /// True if exactly the expected rules are violated, live and in the recording.
    fn is_right(&self, expected: &BTreeSet<&'static str>) -> bool {
        self.violated == *expected && self.recorded == self.violated
    }

    /// Describes the difference between the expected and the violated rules.
    fn mismatch_text(&self, expected: &BTreeSet<&'static str>) -> String {
        let recorded = match &self.recorded {
            same if *same == self.violated => String::new(),
            other => format!(", and {} in the recording", list(other)),
        };
        let failure = self.failure.as_ref().map_or_else(String::new, |failure| format!("; {failure}"));
        format!("expected {}, found {}{recorded}{failure}", list(expected), list(&self.violated))
    }
}

/// Checks the conforming captures: a flight in each encoding, and a Flockwave session. No findings are expected.
pub fn conforming(definitions: &Definitions) -> Vec<(&'static str, CaptureResult)> {
    let flight = Flight::new(definitions);
    let flights =
        Encoding::ALL.into_iter().filter_map(|encoding| Some((encoding.name(), encoding.write(&flight)?)));
    let captures = flights.chain([("Flockwave", Session::new().to_bytes())]);
    let checked =
        |(name, bytes): (_, Vec<u8>)| Some((name, check_capture(&bytes[..], None, definitions).ok()?));
    captures.filter_map(checked).collect()
}

/// Checks all mutants of all rules.
pub fn matrix(definitions: &Definitions) -> Vec<Row> {
    rows(definitions, mutants())
}

/// Checks mutants.
pub fn rows(definitions: &Definitions, mutants: impl Iterator<Item = Mutant>) -> Vec<Row> {
    let flight = Flight::new(definitions);
    let violated = |bytes: Vec<u8>| Some(violated(&check_capture(&bytes[..], None, definitions).ok()?));
    let rows_of = |mutant: Mutant| {
        let row = |title, violated| Row { rule: mutant.rule, mutant: mutant.clone(), title, violated };
        let captures = mutant.captures(&flight).into_iter();
        let rows: Vec<Row> = captures.map(|(title, bytes)| row(title, violated(bytes))).collect();
        if rows.is_empty() { vec![row(mutant.name.to_owned(), None)] } else { rows }
    };
    mutants.flat_map(rows_of).collect()
}

/// Formats a list of rule ids.
pub fn list<'i>(ids: impl IntoIterator<Item = &'i &'static str>) -> String {
    let ids: Vec<&str> = ids.into_iter().copied().collect();
    if ids.is_empty() { "nothing".to_owned() } else { ids.join(", ") }
}

fn violated(result: &CaptureResult) -> BTreeSet<&'static str> {
    result.findings.groups().map(|group| group.rule.id).collect()
}
