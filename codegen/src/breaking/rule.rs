//! Rules on changes, and what they report.

use super::comparison::{CodeChange, MessageChange};
use super::message::{ConstantChange, Pair};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::{Finding, Sides};
use crate::schema::Field;
use crate::source::Span;

/// Whom a change breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Category {
    /// Programs that are built from the definitions: names and types in their source.
    Source,
    /// Programs that exchange messages as JSON.
    Json,
    /// Peers over DDS or ROS 2, whose messages are CDR.
    Cdr,
    /// Peers in uORB, readers of its logs (`ULog`) and of shared memory.
    Uorb,
    /// Whoever relies on PX4's rule that a versioned message says when it changes.
    Version,
    /// Whoever gives a value its meaning: units, frames, numbers of constants, error codes.
    Semantic,
}

impl Category {
    /// All categories, in the order in which they are reported.
    pub const ALL: [Self; 6] =
        [Self::Source, Self::Json, Self::Cdr, Self::Uorb, Self::Version, Self::Semantic];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Source => "source",
            Self::Json => "json",
            Self::Cdr => "cdr",
            Self::Uorb => "uorb",
            Self::Version => "version",
            Self::Semantic => "semantic",
        }
    }
}

/// A kind of change.
#[derive(Debug)]
pub struct Rule {
    /// Its id, which never changes its meaning and is never used again.
    pub id: &'static str,
    /// What the change is, and what comes of it.
    pub purpose: &'static str,
    /// Whom it may break, and how badly.
    pub breaks: &'static [(Category, Level)],
    /// Definitions before such a change.
    pub old: &'static [Example],
    /// The same definitions after it.
    pub new: &'static [Example],
    /// What finds such changes.
    pub(crate) check: Check,
}

/// What finds changes of a kind.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Check {
    /// Looks at each message, service and action that is only in one set, or is called otherwise in the other.
    Interface(fn(&MessageChange<'_>, &mut Sink<'_>)),
    /// Looks at each message that is in both sets.
    Message(fn(&Pair<'_>, &mut Sink<'_>)),
    /// Looks at each field that is in both, under whatever name.
    Field(fn(&Pair<'_>, &Field, &Field, &mut Sink<'_>)),
    /// Looks at each constant that changed.
    Constant(fn(&Pair<'_>, &ConstantChange<'_>, &mut Sink<'_>)),
    /// Looks at each error code that changed.
    ErrorCode(fn(&CodeChange<'_>, &mut Sink<'_>)),
}

/// Takes what a rule finds.
#[derive(Debug)]
pub(crate) struct Sink<'f> {
    pub(super) rule: &'static Rule,
    pub(super) findings: &'f mut Vec<Finding>,
}

/// A change that is being reported.
#[derive(Debug)]
pub(crate) struct Change<'s, 'f> {
    sink: &'s mut Sink<'f>,
    finding: Finding,
}

impl<'f> Sink<'f> {
    /// Reports a change. `span` is where it is in the new set, or what held it there.
    pub(super) fn change(&mut self, span: Span, sides: Sides, message: String) -> Change<'_, 'f> {
        let finding = Finding::new(self.rule.id, Level::Note, span, message);
        Change { sink: self, finding: Finding { sides: Some(sides), ..finding } }
    }
}

impl Change<'_, '_> {
    /// Adds another place that has to do with it.
    pub(super) fn relate(&mut self, span: Span, label: impl Into<String>) -> &mut Self {
        self.finding.relate(span, label);
        self
    }

    /// Says that it breaks a category, and what comes of it there.
    pub(super) fn breaks(&mut self, category: Category, help: impl Into<String>) -> &mut Self {
        let declared = self.sink.rule.breaks.iter().find(|(declared, _)| *declared == category);
        debug_assert!(declared.is_some(), "{} doesn't declare {}", self.sink.rule.id, category.name());
        let level = declared.map_or(Level::Error, |(_, level)| *level);
        let help = help.into();
        let finding = Finding { category: Some(category.name()), level, help, ..self.finding.clone() };
        self.sink.findings.push(finding);
        self
    }
}
