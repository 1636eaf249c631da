//! The steps of a conversion.

use std::collections::BTreeMap;
use std::sync::Arc;

use uavspec_schema::MessageId;
use uavspec_schema::span::Span;

use super::expression::Expression;

/// Converts messages of one type to another type.
#[derive(Clone, Debug)]
pub struct Conversion {
    /// The source message, in the schema of the source.
    pub from: MessageId,
    /// The target message, in the schema of the target.
    pub to: MessageId,
    /// One step for each field of the target, in declaration order. A field whose conversion is undecided has the step
    /// [`Step::Fill`].
    pub steps: Vec<Step>,
    /// The data that the conversion loses.
    pub losses: Vec<Loss>,
    /// The indices of target fields that can get a value that the target's definition excludes. All other fields
    /// satisfy their definition if the source does.
    pub unchecked: Vec<usize>,
    /// The parts that neither the definitions nor the hints decide.
    pub undecided: Vec<Undecided>,
    /// A nested message whose conversion is undecided.
    pub blocked_by: Option<MessageId>,
    /// True if hints decide a part.
    pub uses_hints: bool,
}

impl Conversion {
    /// True if the definitions and hints decide all parts. Only then may the conversion be used.
    pub fn is_decided(&self) -> bool {
        self.undecided.is_empty() && self.blocked_by.is_none()
    }

    /// True if the value of the source field with this index is not lost.
    pub fn keeps(&self, source: usize) -> bool {
        self.losses.iter().all(|loss| loss.source != Some(source))
    }
}

/// The origin of the value of a target field.
#[derive(Clone, Debug)]
pub enum Step {
    /// A field of the source.
    Copy(Copy),
    /// The neutral value, in each element.
    Fill(Neutral),
    /// A hint. The result is limited to the range of the field's type.
    Compute(Expression),
}

/// Copies a field of the source.
#[derive(Clone, Debug)]
pub struct Copy {
    /// The index of the source field.
    pub source: usize,
    /// The conversion of each element. Elements beyond the length of the target are dropped.
    pub elements: Elements,
    /// The value for target elements without a source element, and for numbers that [`Narrowing::Neutral`] replaces.
    pub rest: Neutral,
    /// The limit, if the field counts the elements of an array that was cut.
    pub limit: Option<CountLimit>,
}

/// The limit of a count.
#[derive(Clone, Debug)]
pub struct CountLimit {
    /// The maximum.
    pub max: u32,
    /// Source values that are not limited, with their values in the target. Such a value has a special meaning, for
    /// example an unknown count, or a name that has a different number in the target.
    pub special: BTreeMap<i128, i128>,
}

impl CountLimit {
    /// Applies the limit to a count.
    pub(super) fn limited(&self, value: i128) -> i128 {
        self.special.get(&value).copied().unwrap_or(value.min(self.max.into()))
    }
}

/// The conversion of an element.
#[derive(Clone, Debug)]
pub enum Elements {
    /// Both types have the same values.
    Same,
    /// A `char[N]` in PX4. Its bytes are cut, or followed by zeros.
    Text,
    /// A string, with the maximum number of characters of the target.
    String(Option<u32>),
    /// A number whose target type has all values of the source type.
    Widen,
    /// A number whose target type lacks some values of the source type.
    Narrow(Narrowing),
    /// A number of an enum: pairs of a source value and its target value. Other values stay the same.
    Values(Vec<(i128, i128)>),
    /// Flags: pairs of a source mask and its target mask. Other bits stay the same.
    Flags(Vec<(i128, i128)>),
    /// A nested message.
    Message(Arc<Conversion>),
}

/// The conversion of numbers that the target type can't represent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Narrowing {
    /// The nearest value.
    Nearest,
    /// The neutral value, for integers.
    Neutral,
}

/// The value of a field or element that the source lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neutral {
    /// False, 0, empty, or the default in the definition.
    Default,
    /// An integer that the definition uses for missing data.
    Int(i128),
    /// A float that the definition uses for missing data; may be NaN.
    Float(f64),
}

/// Data that a conversion loses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The index of the source field; `None` if the loss concerns no single field.
    pub source: Option<usize>,
    /// The kind.
    pub kind: LossKind,
    /// A sentence without a period, such as `` `count` is dropped ``.
    pub text: String,
}

/// The kinds of losses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// The target has no such field.
    Dropped,
    /// The target's array or string is shorter.
    Cut,
    /// The target's type has fewer values.
    Narrowed,
    /// Several values have the same counterpart.
    Merged,
    /// A hint computes the value of the target field.
    Computed,
    /// A nested message loses data.
    Nested,
}

/// A part of a conversion that neither the definitions nor the hints decide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undecided {
    /// The location in the new definition, or in the hints.
    pub span: Span,
    /// The location in the old definition.
    pub old: Option<Span>,
    /// The difference.
    pub message: String,
    /// A hint that would decide this part.
    pub help: String,
}
