//! Disagreements that are known, with who is right and why: `xtask/interop/disagreements.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use globset::{Glob, GlobMatcher};
use serde::Deserialize;

use super::job::Form;
use super::tally::{Disagreement, Does, Tally};

/// All that is known.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Known {
    /// What tools see in another way.
    #[serde(default)]
    pub(super) disagreement: Vec<Entry>,
    /// What no schema can say.
    #[serde(default)]
    pub(super) beyond: Vec<Beyond>,
}

/// A disagreement, explained.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    pub(super) id: String,
    pub(super) tools: Vec<String>,
    pub(super) does: Does,
    /// In what form the schemas are; in both, where it doesn't say.
    pub(super) form: Option<Form>,
    /// Patterns of `package/Type#case`, or of `package/Type` where whole schemas are meant. `*` stands for anything.
    pub(super) places: Vec<String>,
    pub(super) right: Right,
    /// What it is judged by.
    pub(super) section: String,
    pub(super) reason: String,
}

/// Who is right.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Right {
    /// The schema and the vectors say what is true, and the tool doesn't.
    Schema,
    /// The specification leaves it to the tool.
    Both,
}

/// A rule that schemas can't express.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Beyond {
    pub(super) rule: String,
    pub(super) reason: String,
}

/// What is left when all explanations are taken into account.
#[derive(Debug, Default)]
pub(super) struct Judgement {
    /// How many disagreements of each tool each entry explains.
    pub(super) explained: BTreeMap<String, BTreeMap<String, usize>>,
    /// What nothing explains, by tool.
    pub(super) unexplained: BTreeMap<String, Vec<Disagreement>>,
    /// Explanations of nothing.
    pub(super) stale: Vec<String>,
}

impl Known {
    /// Reads the file; `tools` are the names that entries may have.
    pub(super) fn read(path: &Path, tools: &BTreeSet<&str>) -> Result<Self, String> {
        let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
        let known: Self = toml::from_str(&text).map_err(|error| at(&error))?;
        let mistakes = known.mistakes(tools);
        if mistakes.is_empty() { Ok(known) } else { Err(at(&mistakes.join("; "))) }
    }

    fn mistakes(&self, tools: &BTreeSet<&str>) -> Vec<String> {
        let mut mistakes = Vec::new();
        let mut ids = BTreeSet::new();
        for entry in &self.disagreement {
            if !ids.insert(&entry.id) {
                mistakes.push(format!("two entries are called `{}`", entry.id));
            }
            let unknown = entry.tools.iter().filter(|tool| !tools.contains(tool.as_str()));
            mistakes.extend(unknown.map(|tool| format!("`{}`: there is no tool `{tool}`", entry.id)));
            let patterns = entry.places.iter().filter_map(|place| Glob::new(place).err());
            mistakes.extend(patterns.map(|error| format!("`{}`: {error}", entry.id)));
        }
        mistakes
    }

    /// Explains what tools that ran disagree in. The first entry that fits explains a disagreement. An entry has to
    /// explain something of each of its tools that ran, and each of its patterns something of one of them.
    pub(super) fn judge(&self, tallies: &BTreeMap<String, Tally>) -> Judgement {
        let mut judgement = Judgement::default();
        let entries: Vec<Matcher<'_>> = self.disagreement.iter().map(Matcher::new).collect();
        let mut used_patterns = BTreeSet::new();
        for (tool, tally) in tallies {
            let explained = judgement.explained.entry(tool.clone()).or_default();
            for disagreement in &tally.disagreements {
                let found =
                    entries.iter().find_map(|entry| Some((entry, entry.explains(tool, disagreement)?)));
                if let Some((Matcher { entry, .. }, pattern)) = found {
                    *explained.entry(entry.id.clone()).or_default() += 1;
                    used_patterns.insert((entry.id.as_str(), pattern));
                } else {
                    judgement.unexplained.entry(tool.clone()).or_default().push(disagreement.clone());
                }
            }
        }
        for entry in &self.disagreement {
            let mut ran =
                entry.tools.iter().filter_map(|tool| Some((tool, judgement.explained.get(tool)?))).peekable();
            if ran.peek().is_none() {
                continue;
            }
            let idle: Vec<&str> = ran
                .filter(|(_, found)| !found.contains_key(&entry.id))
                .map(|(tool, _)| tool.as_str())
                .collect();
            judgement
                .stale
                .extend(idle.iter().map(|tool| format!("`{}` explains nothing of {tool}", entry.id)));
            let needless = entry.places.iter().enumerate();
            let needless =
                needless.filter(|(index, _)| !used_patterns.contains(&(entry.id.as_str(), *index)));
            judgement
                .stale
                .extend(needless.map(|(_, place)| format!("`{}`: `{place}` explains nothing", entry.id)));
        }
        judgement
    }

    /// What is wrong with the list of rules that schemas can't express, given those that are broken so.
    pub(super) fn check_beyond(&self, rules: &BTreeMap<String, usize>) -> Vec<String> {
        let listed: BTreeSet<&str> = self.beyond.iter().map(|entry| entry.rule.as_str()).collect();
        let missing = rules.keys().filter(|rule| !listed.contains(rule.as_str()));
        let missing =
            missing.map(|rule| format!("schemas take cases that break {rule}, and no `[[beyond]]` says why"));
        let needless = listed.iter().filter(|rule| !rules.contains_key(**rule));
        missing
            .chain(needless.map(|rule| format!("`[[beyond]]` names {rule}, which no case breaks so")))
            .collect()
    }
}

/// An entry with its patterns, made ready.
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
