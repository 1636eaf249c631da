//! Known disagreements and their explanations: `xtask/interop/disagreements.toml`.

use std::collections::{BTreeMap, BTreeSet};

use globset::{Glob, GlobMatcher};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};

use super::job::Form;
use super::tally::{Disagreement, Does, Tally};

/// The content of the file.
#[derive(Debug, Deserialize)]
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
    #[serde(deserialize_with = "matchers")]
    pub(super) places: Vec<GlobMatcher>,
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

impl Known {
    /// Reads the file. `tools` are the valid names of tools.
    pub(super) fn parse(text: &str, tools: &BTreeSet<&str>) -> Result<Self, String> {
        let known: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        let mut ids = BTreeSet::new();
        let mut errors = Vec::new();
        for Entry { id, tools: named, .. } in &known.disagreement {
            if !ids.insert(id) {
                errors.push(format!("duplicate entry `{id}`"));
            }
            let unknown = named.iter().filter(|tool| !tools.contains(tool.as_str()));
            errors.extend(unknown.map(|tool| format!("`{id}`: unknown tool `{tool}`")));
        }
        if errors.is_empty() { Ok(known) } else { Err(errors.join("; ")) }
    }

    /// Removes the disagreements that an entry explains, and counts them by entry. The first matching entry explains a
    /// disagreement. Returns an error for each entry that explains no disagreement of one of its tools that ran, and
    /// for each pattern that matches no disagreement.
    pub(super) fn classify(&self, tallies: &mut BTreeMap<String, Tally>) -> Vec<String> {
        let mut used_patterns = BTreeSet::new();
        for (tool, tally) in &mut *tallies {
            let explained = &mut tally.record.explained;
            tally.disagreements.retain(|disagreement| {
                let mut entries = self.disagreement.iter();
                let found = entries.find_map(|entry| Some((&entry.id, entry.explains(tool, disagreement)?)));
                if let Some((id, _)) = found {
                    *explained.entry(id.clone()).or_default() += 1;
                }
                used_patterns.extend(found);
                found.is_none()
            });
        }
        let mut stale = Vec::new();
        for entry in &self.disagreement {
            let id = &entry.id;
            let ran = entry.tools.iter().filter_map(|tool| Some((tool, tallies.get(tool)?)));
            let ran: Vec<(&String, &Tally)> = ran.collect();
            let unused = ran.iter().filter(|(_, tally)| !tally.record.explained.contains_key(id));
            stale.extend(unused.map(|(tool, _)| format!("`{id}` matches no disagreement of {tool}")));
            let places = entry.places.iter().enumerate().filter(|_| !ran.is_empty());
            let unused = places.filter(|(index, _)| !used_patterns.contains(&(id, *index)));
            stale.extend(
                unused.map(|(_, place)| format!("`{id}`: `{}` matches no disagreement", place.glob())),
            );
        }
        stale
    }

    /// Compares `rules` with the list of rules that schemas can't express, and returns the errors.
    pub(super) fn check_beyond(&self, rules: &BTreeMap<String, usize>) -> Vec<String> {
        let listed: BTreeSet<&String> = self.beyond.iter().map(|entry| &entry.rule).collect();
        let missing = rules
            .keys()
            .filter(|rule| !listed.contains(rule))
            .map(|rule| format!("schemas accept violations of {rule}, which has no entry in `[[beyond]]`"));
        let unused = listed
            .iter()
            .filter(|rule| !rules.contains_key(**rule))
            .map(|rule| format!("`[[beyond]]` contains {rule}, but schemas reject all its violations"));
        missing.chain(unused).collect()
    }
}

impl Entry {
    /// The index of the pattern that explains a disagreement.
    fn explains(&self, tool: &str, found: &Disagreement) -> Option<usize> {
        let is_about = self.tools.iter().any(|name| name == tool)
            && self.does == found.does
            && self.form.is_none_or(|form| form == found.form);
        is_about.then(|| self.places.iter().position(|place| place.is_match(&found.place)))?
    }
}

fn matchers<'de, D: Deserializer<'de>>(input: D) -> Result<Vec<GlobMatcher>, D::Error> {
    let patterns = Vec::<String>::deserialize(input)?;
    let globs = patterns.iter().map(|pattern| Glob::new(pattern).map(|glob| glob.compile_matcher()));
    globs.collect::<Result<_, _>>().map_err(D::Error::custom)
}
