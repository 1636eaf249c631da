//! Known disagreements and their explanations: `xtask/interop/disagreements.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use globset::{Glob, GlobMatcher};
use serde::Deserialize;

use super::job::Form;
use super::tally::{Disagreement, Does, Tally};

/// The content of the file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Known {
    /// Explained disagreements.
    #[serde(default)]
    pub(super) disagreement: Vec<Entry>,
    /// Rules that schemas can't express.
    #[serde(default)]
    pub(super) beyond: Vec<Beyond>,
}

/// An explained disagreement.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    pub(super) id: String,
    pub(super) tools: Vec<String>,
    pub(super) does: Does,
    /// The form of the schemas; `None` for both.
    pub(super) form: Option<Form>,
    /// Glob patterns of `package/Type#case`, or of `package/Type` for whole schemas.
    pub(super) places: Vec<String>,
    pub(super) right: Right,
    /// The section of the specification.
    pub(super) section: String,
    pub(super) reason: String,
}

/// The party that is correct.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Right {
    /// The schema and the vectors are correct; the tool is wrong.
    Schema,
    /// The specification allows both results.
    Both,
}

/// A rule that schemas can't express.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Beyond {
    pub(super) rule: String,
    pub(super) reason: String,
}

/// The disagreements, classified by their explanations.
#[derive(Debug, Default)]
pub(super) struct Classification {
    /// The number of explained disagreements, by tool and explanation.
    pub(super) explained: BTreeMap<String, BTreeMap<String, usize>>,
    /// The unexplained disagreements, by tool.
    pub(super) unexplained: BTreeMap<String, Vec<Disagreement>>,
    /// Explanations that apply to no disagreement.
    pub(super) stale: Vec<String>,
}

impl Known {
    /// Reads the file. `tools` are the valid names of tools.
    pub(super) fn read(path: &Path, tools: &BTreeSet<&str>) -> Result<Self, String> {
        let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
        let known: Self = toml::from_str(&text).map_err(|error| at(&error))?;
        let errors = known.errors(tools);
        if errors.is_empty() { Ok(known) } else { Err(at(&errors.join("; "))) }
    }

    fn errors(&self, tools: &BTreeSet<&str>) -> Vec<String> {
        let mut errors = Vec::new();
        let mut ids = BTreeSet::new();
        for entry in &self.disagreement {
            if !ids.insert(&entry.id) {
                errors.push(format!("duplicate entry `{}`", entry.id));
            }
            let unknown = entry.tools.iter().filter(|tool| !tools.contains(tool.as_str()));
            errors.extend(unknown.map(|tool| format!("`{}`: unknown tool `{tool}`", entry.id)));
            let patterns = entry.places.iter().filter_map(|place| Glob::new(place).err());
            errors.extend(patterns.map(|error| format!("`{}`: {error}", entry.id)));
        }
        errors
    }

    /// Classifies the disagreements of the tools that ran. The first matching entry explains a disagreement. An entry
    /// must explain at least one disagreement for each of its tools that ran. Each pattern of an entry must match at
    /// least one disagreement.
    pub(super) fn classify(&self, tallies: &BTreeMap<String, Tally>) -> Classification {
        let mut classification = Classification::default();
        let entries: Vec<Matcher<'_>> = self.disagreement.iter().map(Matcher::new).collect();
        let mut used_patterns = BTreeSet::new();
        for (tool, tally) in tallies {
            let explained = classification.explained.entry(tool.clone()).or_default();
            for disagreement in &tally.disagreements {
                let found =
                    entries.iter().find_map(|entry| Some((entry, entry.explains(tool, disagreement)?)));
                if let Some((Matcher { entry, .. }, pattern)) = found {
                    *explained.entry(entry.id.clone()).or_default() += 1;
                    used_patterns.insert((entry.id.as_str(), pattern));
                } else {
                    classification.unexplained.entry(tool.clone()).or_default().push(disagreement.clone());
                }
            }
        }
        for entry in &self.disagreement {
            let mut ran = entry
                .tools
                .iter()
                .filter_map(|tool| Some((tool, classification.explained.get(tool)?)))
                .peekable();
            if ran.peek().is_none() {
                continue;
            }
            let unused: Vec<&str> = ran
                .filter(|(_, found)| !found.contains_key(&entry.id))
                .map(|(tool, _)| tool.as_str())
                .collect();
            classification.stale.extend(
                unused.iter().map(|tool| format!("`{}` matches no disagreement of {tool}", entry.id)),
            );
            let unused = entry.places.iter().enumerate();
            let unused = unused.filter(|(index, _)| !used_patterns.contains(&(entry.id.as_str(), *index)));
            classification.stale.extend(
                unused.map(|(_, place)| format!("`{}`: `{place}` matches no disagreement", entry.id)),
            );
        }
        classification
    }

    /// Compares `rules` with the list of rules that schemas can't express, and returns the errors.
    pub(super) fn check_beyond(&self, rules: &BTreeMap<String, usize>) -> Vec<String> {
        let listed: BTreeSet<&str> = self.beyond.iter().map(|entry| entry.rule.as_str()).collect();
        let missing = rules.keys().filter(|rule| !listed.contains(rule.as_str()));
        let missing = missing
            .map(|rule| format!("schemas accept violations of {rule}, which has no entry in `[[beyond]]`"));
        let unused = listed.iter().filter(|rule| !rules.contains_key(**rule));
        missing
            .chain(
                unused.map(|rule| {
                    format!("`[[beyond]]` contains {rule}, but schemas reject all its violations")
                }),
            )
            .collect()
    }
}

/// An entry with compiled patterns.
struct Matcher<'k> {
    entry: &'k Entry,
    places: Vec<Option<GlobMatcher>>,
}

impl<'k> Matcher<'k> {
    fn new(entry: &'k Entry) -> Self {
        let places =
            entry.places.iter().map(|place| Some(Glob::new(place).ok()?.compile_matcher())).collect();
        Self { entry, places }
    }

    /// The index of the pattern that explains a disagreement.
    fn explains(&self, tool: &str, found: &Disagreement) -> Option<usize> {
        let is_about = self.entry.tools.iter().any(|name| name == tool)
            && self.entry.does == found.does
            && self.entry.form.is_none_or(|form| form == found.form);
        let fits =
            |place: &Option<GlobMatcher>| place.as_ref().is_some_and(|place| place.is_match(&found.place));
        is_about.then(|| self.places.iter().position(fits))?
    }
}
