//! Settings of a lint run.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_dynamic::conversion::Request;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::source::{SourceId, Span};

use super::rule::{Preset, Rule};

/// The levels of the rules, and the ignored findings.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The preset that determines the initial levels.
    pub preset: Preset,
    /// Levels of individual rules, by id. `None` switches a rule off.
    pub levels: BTreeMap<String, Option<Level>>,
    /// The ignores in the configuration.
    pub ignores: Vec<Ignore>,
    /// The conversions to check.
    pub conversions: Vec<Request>,
}

impl Settings {
    /// The level of a rule, or `None` if the rule is switched off.
    pub fn level(&self, rule: &Rule) -> Option<Level> {
        self.levels.get(rule.id).copied().unwrap_or_else(|| rule.levels.of(self.preset))
    }
}

/// A configuration entry that ignores findings of a rule.
#[derive(Clone, Debug)]
pub struct Ignore {
    /// The rule.
    pub rule: String,
    /// The sources that the entry applies to. `None` for all sources.
    pub sources: Option<BTreeSet<SourceId>>,
    /// The reason.
    pub reason: String,
    /// The location of the entry.
    pub span: Span,
}
