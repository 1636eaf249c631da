//! Codes of which only one stands for the same event, by how grave it is.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;

/// How many alternatives a code may name. There are four severities, and the largest set known has
/// three codes; without a limit a hostile page could make the sets grow with its square.
const MAX_NAMED: usize = 16;

/// What the descriptions name, before it is made mutual.
#[derive(Default)]
pub(super) struct Alternatives {
    /// For each code the alternatives that its own description names, and where.
    named: BTreeMap<u32, BTreeMap<u32, Span>>,
    /// Where a description names one more than it may.
    too_many: BTreeMap<u32, Span>,
}

impl Alternatives {
    /// Notes that the description of `code` names `other` at `span`.
    pub(super) fn add(&mut self, code: u32, other: u32, span: Span) {
        let named = self.named.entry(code).or_default();
        if named.len() < MAX_NAMED || named.contains_key(&other) {
            named.entry(other).or_insert(span);
        } else {
            self.too_many.entry(code).or_insert(span);
        }
    }

    /// What is wrong with them: most often that two codes don't name each other.
    pub(super) fn check(&self, known: &BTreeMap<u32, Option<Span>>) -> Vec<Diagnostic> {
        let too_many = |code| Problem::TooManyAlternatives { code, max: MAX_NAMED };
        let mut diagnostics: Vec<Diagnostic> =
            self.too_many.iter().map(|(code, span)| Diagnostic::new(too_many(*code), *span)).collect();
        for (code, others) in &self.named {
            for (other, span) in others {
                let names_back = self.named.get(other).is_some_and(|back| back.contains_key(code));
                let is_mutual = names_back || self.too_many.contains_key(other);
                // A row that can't be read may well name this one.
                let Some(definition) = known.get(other).copied().flatten().filter(|_| !is_mutual) else {
                    continue;
                };
                let problem = Problem::OneSidedAlternative { code: *code, other: *other };
                let label = format!("{other} doesn't name {code}");
                diagnostics.push(Diagnostic::new(problem, *span).with_related(definition, label));
            }
        }
        diagnostics
    }

    /// For each code its alternatives. A code and those that it names are all alternatives of each
    /// other. Sets of different codes are not joined: where they overlap but differ, a reference is
    /// wrong in one of them, and joining would spread it to all.
    pub(super) fn closed(&self) -> BTreeMap<u32, BTreeSet<u32>> {
        let mut closed: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for (code, others) in &self.named {
            let set: Vec<u32> = others.keys().copied().chain([*code]).collect();
            for member in &set {
                closed.entry(*member).or_default().extend(set.iter().filter(|other| *other != member));
            }
        }
        closed
    }
}
