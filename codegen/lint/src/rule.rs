//! Lint rules and their findings.

use uavspec_dynamic::conversion::Answer;
use uavspec_schema::diagnostic::{Diagnostic, Level};
use uavspec_schema::example::Example;
use uavspec_schema::finding::{Edit, Finding};
use uavspec_schema::source::{SourceMap, Span};
use uavspec_schema::{Package, Schema};

use super::subject::{SourceText, Subject};

/// A lint rule.
#[derive(Debug)]
pub struct Rule {
    /// The id. The meaning of an id never changes, and ids are never reused.
    pub id: &'static str,
    /// A description of the findings.
    pub statement: &'static str,
    /// The consequences of a violation.
    pub why: &'static str,
    /// The way to correct a violation.
    pub fix: &'static str,
    /// The level in each preset.
    pub levels: Levels,
    /// A definition that violates the rule.
    pub bad: Example,
    /// The corrected definition.
    pub good: Example,
    /// The number of findings in PX4's definitions, if they were counted.
    pub measured: Option<Measured>,
    /// The check.
    pub check: Check,
}

/// The level of a rule in each preset, or `None` if the preset doesn't include the rule.
#[derive(Clone, Copy, Debug)]
pub struct Levels {
    /// The level in [`Preset::Px4`].
    pub px4: Option<Level>,
    /// The level in [`Preset::Strict`].
    pub strict: Option<Level>,
}

impl Levels {
    /// Creates levels that are the same in both presets.
    pub const fn both(level: Level) -> Self {
        Self { px4: Some(level), strict: Some(level) }
    }

    /// Creates the levels of a rule that only the strict preset includes.
    pub const fn strict(level: Level) -> Self {
        Self { px4: None, strict: Some(level) }
    }

    /// The level in a preset.
    pub fn of(self, preset: Preset) -> Option<Level> {
        match preset {
            Preset::Px4 => self.px4,
            Preset::Strict => self.strict,
        }
    }
}

/// The findings of a rule in PX4's definitions (`px4_msgs` main at a4a9864).
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// The number of findings.
    pub findings: usize,
    /// The number of reviewed findings: either all findings, or a random sample of thirty.
    pub sample: usize,
    /// The number of correct findings in the sample. A finding is correct if an expert would change the definition.
    pub right: usize,
}

/// The check of a rule.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// The parser reports the violation as a warning with the same id. The function returns the edits that fix the
    /// violation, if there is a fix.
    Reader(fn(&Diagnostic, &SourceMap) -> Vec<Edit>),
    /// Checks the text of each source.
    Text(fn(&SourceText<'_>, &mut Sink<'_>)),
    /// Checks each message of a scope, including the parts of services and actions.
    Message(Scope, fn(&Subject<'_>, &mut Sink<'_>)),
    /// Checks each package.
    Package(fn(&Package, &SourceMap, &mut Sink<'_>)),
    /// Checks the whole schema, for example packages against each other.
    Schema(fn(&Schema, &mut Sink<'_>)),
    /// Checks the conversions that share a file with hints.
    Conversion(fn(&Converted<'_>, &mut Sink<'_>)),
    /// Checks the ignore comments.
    Ignores,
}

/// The messages to which a rule applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The messages of all dialects.
    All,
    /// The messages in PX4's dialect, to which PX4's documentation standard applies.
    Px4,
    /// The messages in PX4's dialect, without parts of services.
    Px4Messages,
}

/// Conversions that share a file with hints.
#[derive(Clone, Copy, Debug)]
pub struct Converted<'a> {
    pub(super) schema: &'a Schema,
    pub(super) answer: &'a Answer,
}

/// The fix function for rules that have no automatic fix.
pub(super) fn no_fix(_: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    Vec::new()
}

/// Collects the findings of a rule.
#[derive(Debug)]
pub struct Sink<'f> {
    pub(super) rule: &'static str,
    pub(super) findings: &'f mut Vec<Finding>,
}

impl Sink<'_> {
    /// Reports a finding. The caller later sets the level of all findings of the rule.
    pub(super) fn report(
        &mut self,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> &mut Finding {
        let mut finding = Finding::new(self.rule, Level::Note, span, message);
        finding.help(help);
        let at = self.findings.len();
        self.findings.push(finding);
        &mut self.findings[at]
    }
}

/// A set of levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Rules of PX4's documentation standard, and rules against ambiguous text.
    #[default]
    Px4,
    /// All rules except unit-unlisted, which allows only units from PX4's list.
    Strict,
}

impl Rule {
    /// The statement and the reason, as one text.
    pub fn purpose(&self) -> String {
        format!("{} {}", self.statement, self.why)
    }
}
