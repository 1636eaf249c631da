//! Rules, and what they report.

use super::subject::{SourceText, Subject};
use crate::diagnostic::{Diagnostic, Level};
use crate::example::Example;
use crate::finding::{Edit, Finding};
use crate::schema::Package;
use crate::source::{SourceMap, Span};

/// A rule.
#[derive(Debug)]
pub struct Rule {
    /// Its id, which never changes its meaning and is never used again.
    pub id: &'static str,
    /// What it demands, and what comes of it where that isn't kept.
    pub purpose: &'static str,
    /// How grave a breach is in each preset; none where the preset leaves the rule out.
    pub levels: Levels,
    /// A definition that breaks it.
    pub bad: Example,
    /// The same definition without that.
    pub good: Example,
    /// What it finds in real definitions, where that was counted.
    pub measured: Option<Measured>,
    /// What finds it.
    pub(crate) check: Check,
}

/// The level of a rule in each preset.
#[derive(Clone, Copy, Debug)]
pub struct Levels {
    /// In [`Preset::Px4`].
    pub px4: Option<Level>,
    /// In [`Preset::Strict`].
    pub strict: Option<Level>,
}

impl Levels {
    /// The same level in both presets.
    pub const fn both(level: Level) -> Self {
        Self { px4: Some(level), strict: Some(level) }
    }

    /// Left out by all presets but the strict one.
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

/// What a rule finds in the definitions of PX4 (`px4_msgs` main at a4a9864), and how much of it is right.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// How many findings there are.
    pub findings: usize,
    /// How many of them were looked at, taken by chance: all, or thirty.
    pub sample: usize,
    /// How many of those are right: whoever knows the definitions would change them.
    pub right: usize,
    /// A word on the others; may be empty.
    pub remark: &'static str,
}

/// What finds breaches of a rule.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Check {
    /// The readers report it under the same id; this mends it, where it can.
    Reader(fn(&Diagnostic, &SourceMap) -> Vec<Edit>),
    /// Looks at each source as text.
    Text(fn(&SourceText<'_>, &mut Sink<'_>)),
    /// Looks at each message, parts of services and actions too.
    Message(fn(&Subject<'_>, &mut Sink<'_>)),
    /// Looks at the error codes of each package.
    ErrorCodes(fn(&Package, &SourceMap, &mut Sink<'_>)),
    /// The ignores themselves.
    Ignores,
}

/// For rules of the readers that take a person to mend.
pub(super) fn no_fix(_: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    Vec::new()
}

/// Takes what a rule finds.
#[derive(Debug)]
pub(crate) struct Sink<'f> {
    pub(super) rule: &'static str,
    pub(super) findings: &'f mut Vec<Finding>,
}

impl Sink<'_> {
    /// Reports a breach. The level is set for all findings of a rule afterwards.
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

/// Sets of levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// What PX4's documentation standard asks, and whatever makes readers go wrong.
    #[default]
    Px4,
    /// All rules but that on PX4's own list of units.
    Strict,
}

impl Rule {
    /// True if the readers of definitions report it themselves.
    pub fn is_of_readers(&self) -> bool {
        matches!(self.check, Check::Reader(_))
    }
}
