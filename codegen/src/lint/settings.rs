//! Settings of a run.

use std::collections::{BTreeMap, BTreeSet};

use super::rule::{Preset, Rule};
use crate::diagnostic::Level;
use crate::source::{SourceId, Span};

/// Which rules apply, how grave they are, and what is let stand.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The levels to start from.
    pub preset: Preset,
    /// Other levels for single rules, by id; none turns the rule off.
    pub levels: BTreeMap<String, Option<Level>>,
    /// What is let stand by configuration.
    pub ignores: Vec<Ignore>,
}

impl Settings {
    /// The level of a rule; none where it is off.
    pub fn level(&self, rule: &Rule) -> Option<Level> {
        self.levels.get(rule.id).copied().unwrap_or_else(|| rule.levels.of(self.preset))
    }
}

/// A request of the configuration to let findings of a rule stand.
#[derive(Clone, Debug)]
pub struct Ignore {
    /// The rule.
    pub rule: String,
    /// In which sources; in all, where absent.
    pub sources: Option<BTreeSet<SourceId>>,
    /// Why.
    pub reason: String,
    /// Where it is asked for.
    pub span: Span,
}
