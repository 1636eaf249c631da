//! Alternative codes for the same event, of different severities.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;

/// The maximum number of alternatives in one description. There are four severities, and the largest known set has
/// three codes. Without a limit, a malicious page could make the sets grow quadratically.
const MAX_NAMED: usize = 16;

/// The alternatives that descriptions list, before missing reverse references are added.
#[derive(Default)]
pub(super) struct Alternatives {
    /// For each code, the alternatives that its description lists, with their locations.
    named: BTreeMap<u32, BTreeMap<u32, Span>>,
    /// For each code, the location of the first alternative above the limit.
    too_many: BTreeMap<u32, Span>,
}

impl Alternatives {
    /// Records that the description of `code` lists `other` at `span`.
    pub(super) fn add(&mut self, code: u32, other: u32, span: Span) {
        let named = self.named.entry(code).or_default();
        if named.len() < MAX_NAMED || named.contains_key(&other) {
            named.entry(other).or_insert(span);
        } else {
            self.too_many.entry(code).or_insert(span);
        }
    }

    /// Reports one-sided alternatives and descriptions with too many alternatives.
    pub(super) fn check(&self, known: &BTreeMap<u32, Option<Span>>) -> Vec<Diagnostic> {
        let too_many = |code| Problem::TooManyAlternatives { code, max: MAX_NAMED };
        let mut diagnostics: Vec<Diagnostic> =
            self.too_many.iter().map(|(code, span)| Diagnostic::new(too_many(*code), *span)).collect();
        for (code, others) in &self.named {
            for (other, span) in others {
                let names_back = self.named.get(other).is_some_and(|back| back.contains_key(code));
                let is_mutual = names_back || self.too_many.contains_key(other);
                // Skip a code whose row can't be read, because the row may list this code.
                let Some(definition) = known.get(other).copied().flatten().filter(|_| !is_mutual) else {
                    continue;
                };
                let problem = Problem::OneSidedAlternative { code: *code, other: *other };
                let label = format!("{other} does not list {code}");
                diagnostics.push(Diagnostic::new(problem, *span).with_related(definition, label));
            }
        }
        diagnostics
    }

    /// The alternatives of each code. All codes in one description are alternatives of each other. Sets from different
    /// descriptions are not merged, because an error in one set would spread to the others.
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
