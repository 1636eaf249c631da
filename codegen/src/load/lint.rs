//! The configuration of `lint` in `uavspec.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use globset::{GlobBuilder, GlobMatcher};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;
use uavspec_lint::Preset;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::path::normalise;

use super::located::failure_at;

/// The table `lint`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Lint {
    /// The rules to check: `px4` (default) or `strict`.
    #[serde(default)]
    #[schemars(schema_with = "super::schema::values_of::<Preset>")]
    preset: Preset,
    /// Levels of individual rules, such as `{ unit-missing = "off" }`: `off`, `note`, `warning` or `error`.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, LevelName>")]
    levels: BTreeMap<Spanned<String>, LevelName>,
    /// Findings to ignore.
    #[serde(default, rename = "ignore")]
    #[schemars(with = "Vec<LintIgnore>")]
    ignores: Vec<Spanned<LintIgnore>>,
}

/// An exception to a rule.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LintIgnore {
    /// Id of the rule.
    rule: String,
    /// Glob pattern of files. Default: all files.
    path: Option<String>,
    /// Reason for the exception.
    reason: String,
}

/// The level of a rule, or off.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum LevelName {
    Off,
    Note,
    Warning,
    Error,
}

impl LevelName {
    fn level(self) -> Option<Level> {
        match self {
            Self::Off => None,
            Self::Note => Some(Level::Note),
            Self::Warning => Some(Level::Warning),
            Self::Error => Some(Level::Error),
        }
    }
}

/// The configuration of `lint`.
#[derive(Debug, Default)]
pub(crate) struct PlannedLint {
    pub(crate) preset: Preset,
    pub(crate) levels: BTreeMap<String, Option<Level>>,
    pub(crate) ignores: Vec<PlannedIgnore>,
}

/// An exception to a rule.
#[derive(Debug)]
pub(crate) struct PlannedIgnore {
    pub(crate) rule: String,
    /// A glob pattern for files, relative to the folder of the configuration file. `None` matches all files.
    pub(crate) files: Option<GlobMatcher>,
    pub(crate) reason: String,
    /// The location in the configuration file.
    pub(crate) range: std::ops::Range<usize>,
}

impl Lint {
    /// Checks the rule names and the patterns. `text` is the content of the file at `path`.
    pub(crate) fn plan(self, folder: &Path, path: &str, text: &str) -> Result<PlannedLint, Failure> {
        let mut levels = BTreeMap::new();
        for (id, level) in self.levels {
            if uavspec_lint::rule(id.get_ref()).is_none() {
                let message = format!("unknown rule `{}`", id.get_ref());
                return Err(
                    failure_at(path, text, id.span(), &message).with_hint("`lint --rules` lists all rules")
                );
            }
            levels.insert(id.into_inner(), level.level());
        }
        let mut ignores = Vec::new();
        for ignore in self.ignores {
            let range = ignore.span();
            let LintIgnore { rule, path: pattern, reason } = ignore.into_inner();
            let glob = |pattern: String| {
                let below = folder.join(&pattern);
                let glob =
                    GlobBuilder::new(&normalise(&below).to_string_lossy()).literal_separator(true).build();
                glob.map(|glob| glob.compile_matcher()).map_err(|error| {
                    failure_at(path, text, range.clone(), &format!("`{pattern}`: {}", error.kind()))
                })
            };
            let files = pattern.map(glob).transpose()?;
            ignores.push(PlannedIgnore { rule, files, reason, range });
        }
        Ok(PlannedLint { preset: self.preset, levels, ignores })
    }
}
