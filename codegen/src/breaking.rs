//! Two sets of definitions compared: what changed, and whom that breaks.
//!
//! Messages, fields and constants are matched first, renamed ones too ([`Comparison`], [`Pair`]); then each
//! rule looks at what was matched, or was not. A rule is one kind of change. It breaks programs by
//! [`Category`], and there is one finding for each of those.
//!
//! Types and messages of pages are not compared yet: no rule says anything of what changes in them.

mod comparison;
mod message;
mod order;
mod signature;

mod array_length_changed;
mod constant_added;
mod constant_removed;
mod constant_renamed;
mod constant_reused;
mod constant_type_changed;
mod constant_value_changed;
mod error_code_abbreviation_changed;
mod error_code_added;
mod error_code_meaning_changed;
mod error_code_removed;
mod error_code_renumbered;
mod error_code_reused;
mod field_added;
mod field_default_changed;
mod field_enum_changed;
mod field_frame_changed;
mod field_invalid_changed;
mod field_moved;
mod field_range_changed;
mod field_removed;
mod field_renamed;
mod field_type_changed;
mod field_unit_changed;
mod message_added;
mod message_removed;
mod message_renamed;
mod message_version;
mod message_version_needless;
mod message_version_removed;
mod nested_changed;
mod queue_length_changed;
mod topic_added;
mod topic_removed;

pub use self::comparison::{CodeChange, Comparison, MessageChange, Named};
pub use self::message::{ConstantChange, FieldChange, Held, Kept, Pair};

use crate::diagnostic::Level;
pub use crate::example::Example;
use crate::finding::{Finding, Sides};
use crate::schema::{Field, Schema};
use crate::source::{SourceMap, Span};

/// Every rule, by id.
pub const RULES: &[&Rule] = &[
    &array_length_changed::RULE,
    &constant_added::RULE,
    &constant_removed::RULE,
    &constant_renamed::RULE,
    &constant_reused::RULE,
    &constant_type_changed::RULE,
    &constant_value_changed::RULE,
    &error_code_abbreviation_changed::RULE,
    &error_code_added::RULE,
    &error_code_meaning_changed::RULE,
    &error_code_removed::RULE,
    &error_code_renumbered::RULE,
    &error_code_reused::RULE,
    &field_added::RULE,
    &field_default_changed::RULE,
    &field_enum_changed::RULE,
    &field_frame_changed::RULE,
    &field_invalid_changed::RULE,
    &field_moved::RULE,
    &field_range_changed::RULE,
    &field_removed::RULE,
    &field_renamed::RULE,
    &field_type_changed::RULE,
    &field_unit_changed::RULE,
    &message_added::RULE,
    &message_removed::RULE,
    &message_renamed::RULE,
    &message_version::RULE,
    &message_version_needless::RULE,
    &message_version_removed::RULE,
    &nested_changed::RULE,
    &queue_length_changed::RULE,
    &topic_added::RULE,
    &topic_removed::RULE,
];

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
    pub check: Check,
}

/// What finds changes of a kind.
#[derive(Clone, Copy, Debug)]
pub enum Check {
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

/// Between which states versions of messages are judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Between commits a changed message has a version that is one higher.
    #[default]
    Commits,
    /// Between releases it may be higher by more: the message may have changed several times.
    Releases,
}

/// Takes what a rule finds.
#[derive(Debug)]
pub struct Sink<'f> {
    rule: &'static Rule,
    findings: &'f mut Vec<Finding>,
}

/// A change that is being reported.
#[derive(Debug)]
pub struct Change<'s, 'f> {
    sink: &'s mut Sink<'f>,
    finding: Finding,
}

impl<'f> Sink<'f> {
    /// Reports a change. `span` is where it is in the new set, or what held it there.
    pub fn change(&mut self, span: Span, sides: Sides, message: String) -> Change<'_, 'f> {
        let finding = Finding::new(self.rule.id, Level::Note, span, message);
        Change { sink: self, finding: Finding { sides: Some(sides), ..finding } }
    }
}

impl Change<'_, '_> {
    /// Adds another place that has to do with it.
    pub fn relate(&mut self, span: Span, label: impl Into<String>) -> &mut Self {
        self.finding.relate(span, label);
        self
    }

    /// Says that it breaks a category, and what comes of it there.
    pub fn breaks(&mut self, category: Category, help: impl Into<String>) -> &mut Self {
        let declared = self.sink.rule.breaks.iter().find(|(declared, _)| *declared == category);
        debug_assert!(declared.is_some(), "{} doesn't declare {}", self.sink.rule.id, category.name());
        let level = declared.map_or(Level::Error, |(_, level)| *level);
        let help = help.into();
        let finding = Finding { category: Some(category.name()), level, help, ..self.finding.clone() };
        self.sink.findings.push(finding);
        self
    }
}

/// The rule of an id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

/// Compares two sets of definitions, both without errors, whose sources are all in `sources`. Sorted by place.
pub fn breaking(sources: &SourceMap, old: &Schema, new: &Schema, between: Between) -> Vec<Finding> {
    let comparison = Comparison::new(old, new, between);
    let mut findings = Vec::new();
    for rule in RULES {
        let mut sink = Sink { rule, findings: &mut findings };
        match rule.check {
            Check::Interface(check) => {
                comparison.changes.iter().for_each(|change| check(change, &mut sink));
            }
            Check::Message(check) => comparison.pairs.iter().for_each(|pair| check(pair, &mut sink)),
            Check::Field(check) => {
                for pair in &comparison.pairs {
                    pair.fields().for_each(|(old, new)| check(pair, old, new, &mut sink));
                }
            }
            Check::Constant(check) => {
                for pair in &comparison.pairs {
                    pair.constants.iter().for_each(|change| check(pair, change, &mut sink));
                }
            }
            Check::ErrorCode(check) => comparison.codes.iter().for_each(|change| check(change, &mut sink)),
        }
    }
    let path = |finding: &Finding| sources.path(sources.source_of(finding.span));
    let key = |finding: &Finding| (finding.span, finding.sides.and_then(|sides| sides.old), finding.rule);
    findings.sort_by(|left, right| (path(left), key(left)).cmp(&(path(right), key(right))));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_so_that_they_can_be_looked_up() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }
}
