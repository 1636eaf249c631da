//! The conversions that a configuration requests.

use std::collections::BTreeMap;

use uavspec_schema::Schema;
use uavspec_schema::source::{SourceId, SourceMap};

use super::build::{Applied, Conversions, Version};
use super::hints::{Hints, Mistake};

/// A request for the conversions between two packages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// The name of the old package.
    pub from: String,
    /// The name of the new package.
    pub to: String,
    /// The hints.
    pub hints: Option<SourceId>,
}

/// Conversions that share a file with hints.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// The hints.
    pub hints: Hints,
    /// The conversions, in the order of the requests.
    pub conversions: Vec<Conversions>,
}

impl Answer {
    /// The mistakes in the hints, in line order.
    pub fn mistakes(&self) -> Vec<Mistake> {
        let found = self.conversions.iter().flat_map(|found| &found.mistakes);
        let mut mistakes: Vec<Mistake> = self.hints.mistakes.iter().chain(found).cloned().collect();
        mistakes.sort_by(|left, right| (left.span, &left.message).cmp(&(right.span, &right.message)));
        mistakes.dedup();
        mistakes
    }

    /// The hints that are never used, each with the reason. A file with mistakes has no unused hints.
    pub fn unused(&self, schema: &Schema) -> Vec<Mistake> {
        if !self.hints.mistakes.is_empty() {
            return Vec::new();
        }
        let versions = self.conversions.iter().map(|found| {
            let version = |package| Version { schema, package };
            (version(found.old), version(found.new))
        });
        let mut applied = Applied::default();
        self.conversions.iter().for_each(|found| applied.merge(&found.applied));
        self.hints.unused(&applied, &versions.collect::<Vec<_>>())
    }
}

/// Answers requests. Requests for unknown packages are skipped. The answers are in the order of the files with hints.
pub fn answer(sources: &SourceMap, schema: &Schema, requests: &[Request]) -> Vec<Answer> {
    let mut answers: BTreeMap<Option<SourceId>, Answer> = BTreeMap::new();
    for request in requests {
        let answer = answers.entry(request.hints).or_insert_with(|| Answer {
            hints: request.hints.map(|id| super::hints::read(sources, id)).unwrap_or_default(),
            conversions: Vec::new(),
        });
        answer.conversions.extend(Conversions::within(schema, &request.from, &request.to, &answer.hints));
    }
    answers.into_values().collect()
}
