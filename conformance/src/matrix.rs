//! Checks all mutants, and compares the violated rules with the expected rules.

pub(crate) mod live;

use std::collections::BTreeSet;

use crate::check::{CaptureResult, check_capture};
use crate::definitions::Definitions;
use crate::model::Rule;
use crate::rules::flockwave::sample::Session;
use crate::rules::sample::{Encoding, Flight};
use crate::rules::{Mutant, mutants};

/// The result for a mutant.
#[derive(Debug)]
pub(crate) struct Row {
    /// The rule that the mutant violates.
    pub rule: &'static Rule,
    /// The mutant.
    pub mutant: Mutant,
    /// The name of the mutant; for PX4 rules, followed by the capture's encoding.
    pub title: String,
    /// The ids of the violated rules. `None` if the definitions don't allow the change.
    pub violated: Option<BTreeSet<&'static str>>,
}

impl Row {
    /// The ids of the rules that the mutant should violate.
    pub(crate) fn expected(&self) -> BTreeSet<&'static str> {
        self.mutant.also.iter().chain([&self.rule]).map(|rule| rule.id).collect()
    }

    /// True if exactly the expected rules are violated, or if the mutant couldn't be made.
    pub(crate) fn is_right(&self) -> bool {
        self.violated.as_ref().is_none_or(|violated| *violated == self.expected())
    }
}

/// Checks the conforming captures: a flight in each encoding, and a Flockwave session. No findings are expected.
pub(crate) fn conforming(definitions: &Definitions) -> Vec<(&'static str, CaptureResult)> {
    let flight = Flight::new(definitions);
    let flights =
        Encoding::ALL.into_iter().filter_map(|encoding| Some((encoding.name(), encoding.write(&flight)?)));
    let captures = flights.chain([("Flockwave", Session::new().to_bytes())]);
    let checked = captures.map(|(name, bytes)| (name, check_bytes(&bytes, definitions)));
    checked.filter_map(|(name, result)| Some((name, result?))).collect()
}

/// Checks all mutants of all rules.
pub(crate) fn matrix(definitions: &Definitions) -> Vec<Row> {
    let flight = Flight::new(definitions);
    let violated = |bytes: Vec<u8>| {
        let result = check_bytes(&bytes, definitions)?;
        Some(result.findings.groups().map(|group| group.rule.id).collect())
    };
    let rows = |mutant: Mutant| {
        let row = |title, violated| Row { rule: mutant.rule, mutant: mutant.clone(), title, violated };
        let captures = mutant.captures(&flight).into_iter();
        let rows: Vec<Row> = captures.map(|(title, bytes)| row(title, violated(bytes))).collect();
        if rows.is_empty() { vec![row(mutant.name.to_owned(), None)] } else { rows }
    };
    mutants().flat_map(rows).collect()
}

/// Formats a list of rule ids.
pub(crate) fn list<'i>(ids: impl IntoIterator<Item = &'i &'static str>) -> String {
    let ids: Vec<&str> = ids.into_iter().copied().collect();
    if ids.is_empty() { "nothing".to_owned() } else { ids.join(", ") }
}

/// Checks a capture in memory.
fn check_bytes(bytes: &[u8], definitions: &Definitions) -> Option<CaptureResult> {
    check_capture(bytes, None, definitions).ok()
}
