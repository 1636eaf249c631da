//! What each rule finds in each mutant of each rule: whether they find what they should, and nothing else.

pub mod live;

use std::collections::BTreeSet;

use crate::check::{CaptureResult, check_capture};
use crate::definitions::Definitions;
use crate::model::Rule;
use crate::rules::sample::{Conversation, Flight};
use crate::rules::{Mutant, mutants};

/// What came of a mutant.
#[derive(Debug)]
pub struct Row {
    /// The rule that it has to break.
    pub rule: &'static Rule,
    /// The mutant.
    pub mutant: Mutant,
    /// The ids of the rules that it broke; none where the definitions have nothing to change so.
    pub broken: Option<BTreeSet<&'static str>>,
}

impl Row {
    /// The ids of the rules that it should break.
    pub fn expected(&self) -> BTreeSet<&'static str> {
        self.mutant.also.iter().copied().chain([self.rule.id]).collect()
    }

    /// Whether it broke what it should, and nothing else; or couldn't be made.
    pub fn is_right(&self) -> bool {
        self.broken.as_ref().is_none_or(|broken| *broken == self.expected())
    }
}

/// The rules that what a flight conforms to finds broken in it, source by source: none, if all is right.
pub fn conforming(definitions: &Definitions) -> Vec<(&'static str, CaptureResult)> {
    let flight = Flight::new(definitions);
    let sources = [
        ("log", flight.log().to_bytes()),
        ("MCAP", flight.bag().to_bytes()),
        ("JSON Lines", flight.lines().to_bytes()),
        ("rosbridge", flight.rosbridge().to_bytes()),
        ("Flockwave", Conversation::new().to_bytes()),
    ];
    let judged = sources.into_iter().map(|(name, bytes)| (name, judge_bytes(&bytes, definitions)));
    judged.filter_map(|(name, judgement)| Some((name, judgement?))).collect()
}

/// Judges all mutants of all rules, made from a flight of some definitions.
pub fn matrix(definitions: &Definitions) -> Vec<Row> {
    let flight = Flight::new(definitions);
    let row = |mutant: Mutant| {
        let judged = mutant.make(&flight).and_then(|bytes| judge_bytes(&bytes, definitions));
        let broken = judged.map(|judged| judged.findings.groups().map(|group| group.rule.id).collect());
        Row { rule: mutant.rule, mutant, broken }
    };
    mutants().map(row).collect()
}

/// Ids of rules, in words.
pub(crate) fn list<'i>(ids: impl IntoIterator<Item = &'i &'static str>) -> String {
    let ids: Vec<&str> = ids.into_iter().copied().collect();
    if ids.is_empty() { "nothing".to_owned() } else { ids.join(", ") }
}

/// Bytes can always be read.
fn judge_bytes(bytes: &[u8], definitions: &Definitions) -> Option<CaptureResult> {
    check_capture(bytes, None, definitions).ok()
}
