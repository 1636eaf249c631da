//! Rules about changes, and their findings.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;
use uavspec_schema::finding::{Finding, Sides};
use uavspec_schema::source::Span;
use uavspec_schema::{EventEnum, Field};

use super::comparison::{CodeChange, EventChange, MessageChange};
use super::message::{ConstantChange, Pair};

/// The users that a change affects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Category {
    /// Programs whose source code uses the names and types in the definitions.
    Source,
    /// Programs that exchange messages as JSON.
    Json,
    /// DDS and ROS 2 peers, which exchange CDR.
    Cdr,
    /// Programs that use uORB memory or read `ULog` files.
    Uorb,
    /// Programs that rely on PX4's versioning rule: a changed message must get a higher version.
    Version,
    /// Programs that rely on the meaning of values: units, frames, constants, error codes.
    Semantic,
}

impl Category {
    /// All categories, in the order of the report.
    pub const ALL: [Self; 6] =
        [Self::Source, Self::Json, Self::Cdr, Self::Uorb, Self::Version, Self::Semantic];

    /// The name in reports.
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

/// A rule: one kind of change.
#[derive(Debug)]
pub struct Rule {
    /// The id. The meaning of an id never changes, and ids are never reused.
    pub id: &'static str,
    /// A description of the change.
    pub statement: &'static str,
    /// The consequences of the change.
    pub why: &'static str,
    /// The way to avoid the consequences.
    pub fix: &'static str,
    /// The categories that the change can affect, with their levels.
    pub breaks: &'static [(Category, Level)],
    /// Example definitions before the change.
    pub old: &'static [Example],
    /// Example definitions after the change.
    pub new: &'static [Example],
    /// The check.
    pub(crate) check: Check,
}

/// The check of a rule.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Check {
    /// Checks each message, service and action that was added, removed or renamed.
    Interface(fn(&MessageChange<'_>, &mut Sink<'_>)),
    /// Checks each message that exists in both versions.
    Message(fn(&Pair<'_>, &mut Sink<'_>)),
    /// Checks each field that exists in both versions, including renamed fields.
    Field(fn(&Pair<'_>, &Field, &Field, &mut Sink<'_>)),
    /// Checks each matched constant.
    Constant(fn(&Pair<'_>, &ConstantChange<'_>, &mut Sink<'_>)),
    /// Checks each matched error code.
    ErrorCode(fn(&CodeChange<'_>, &mut Sink<'_>)),
    /// Checks each event.
    Event(fn(&EventChange<'_>, &mut Sink<'_>)),
    /// Checks each enum of events that both versions have.
    EventEnum(fn(&EventEnum, &EventEnum, &mut Sink<'_>)),
}

/// Collects the findings of a rule.
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
    /// Reports a change. `span` is the location of the changed item in the new version. For a removed item, `span` is
    /// the location of the enclosing item.
    pub(super) fn change(&mut self, span: Span, sides: Sides, message: String) -> Change<'_, 'f> {
        let finding = Finding::new(self.rule.id, Level::Note, span, message);
        Change { sink: self, finding: Finding { sides: Some(sides), ..finding } }
    }
}

impl Rule {
    /// The statement and the consequences, as one text.
    pub fn purpose(&self) -> String {
        format!("{} {}", self.statement, self.why)
    }
}

impl Change<'_, '_> {
    /// Adds a related location.
    pub(super) fn relate(&mut self, span: Span, label: impl Into<String>) -> &mut Self {
        self.finding.relate(span, label);
        self
    }

    /// Adds a finding for a category, with a description of the consequences.
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
