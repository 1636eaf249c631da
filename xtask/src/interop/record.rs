//! The results of the latest run of each tool, in `xtask/interop/results.json`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::adapter::End;
use super::job::Form;
use super::tally::{Count, Tally};

/// The results of all tools.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct Record {
    /// The number of violating cases for each rule that schemas can't express.
    pub(super) beyond: BTreeMap<String, usize>,
    pub(super) tools: BTreeMap<String, ToolRecord>,
}

/// The results of a tool, without machine-dependent values.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct ToolRecord {
    pub(super) version: String,
    pub(super) end: String,
    /// The counts by form and package.
    pub(super) counts: BTreeMap<Form, BTreeMap<String, Count>>,
    /// The number of disagreements that each entry explains.
    pub(super) explained: BTreeMap<String, usize>,
}

impl Record {
    /// Reads the file. Returns an empty record if it doesn't exist.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        match fs::read_to_string(path) {
            Ok(text) => serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display())),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(format!("{}: {error}", path.display())),
        }
    }

    /// The text of the file.
    pub(super) fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("records contain only string keys and numbers");
        format!("{text}\n")
    }

    /// Replaces the results of a tool.
    pub(super) fn set(&mut self, tool: &str, tally: &Tally, explained: BTreeMap<String, usize>) {
        let mut counts: BTreeMap<Form, BTreeMap<String, Count>> = BTreeMap::new();
        for ((form, package), count) in &tally.counts {
            counts.entry(*form).or_default().insert(package.clone(), *count);
        }
        let end = match tally.end {
            End::Finished => "finished",
            End::Crashed(_) => "crashed",
            End::Hung => "hung",
            End::Garbage(_) => "garbage",
        };
        let version = tally.version.clone().unwrap_or_else(|| "unknown".to_owned());
        self.tools.insert(tool.to_owned(), ToolRecord { version, end: end.to_owned(), counts, explained });
    }
}
