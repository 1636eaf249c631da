//! The compiled form of a type, for codecs and checks.

use std::ops::Range;
use std::sync::OnceLock;

use uavspec_runtime::Number;
use uavspec_runtime::layout::Size;
use uavspec_schema::source::Span;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Restriction, Shape, Type};

use super::error::Defect;
use super::members::Named;

/// A compiled message type.
#[derive(Debug)]
#[allow(clippy::struct_excessive_bools)] // the flags are independent
pub(super) struct Plan {
    pub(super) package: Box<str>,
    pub(super) name: Box<str>,
    pub(super) span: Span,
    /// Fields in declaration order.
    pub(super) fields: Box<[Field]>,
    /// Size of the fixed part, which is the whole message if `is_fixed`.
    pub(super) size: Size,
    /// True if the message contains no strings and no sequences.
    pub(super) is_fixed: bool,
    /// Minimum CDR size in bytes, without alignment padding.
    pub(super) min: usize,
    /// True if any field, including fields of nested messages, has a nonzero default.
    pub(super) has_defaults: bool,
    /// True if any field, including fields of nested messages, is a `bool`.
    pub(super) has_bools: bool,
    /// True if the message can contain a value that violates a rule.
    pub(super) is_restricted: bool,
    /// The reason why the type is unusable.
    pub(super) defect: Option<Defect>,
    /// Set when the first message is read from CDR or written to it.
    pub(super) transfer: OnceLock<Option<Transfer>>,
}

/// The parts of a message whose bytes are equal in memory and in little-endian CDR. Only a message of fixed size has them.
#[derive(Debug, Default)]
pub(super) struct Transfer {
    /// The parts, in the order of CDR: the offset after the header, the offset in memory, and the length.
    pub(super) parts: Vec<(usize, usize, usize)>,
    /// The places of `bool`s in CDR, as offsets after the header. In memory, any other byte than 0 is true.
    pub(super) bools: Vec<Range<usize>>,
    /// The size of the message in CDR, without the header.
    pub(super) size: usize,
}

/// A field with its position in memory.
#[derive(Debug)]
pub struct Field {
    /// The name.
    pub name: Box<str>,
    /// The type of the field or its elements. [`MessageType::nested`](super::MessageType::nested) returns the type of a
    /// nested message.
    pub element: Element,
    /// The number of elements. A text is a single element.
    pub shape: Shape,
    /// The offset in the message, in bytes.
    pub offset: usize,
    /// The distance between elements, in bytes.
    pub stride: usize,
    /// The constraints on numbers, if the definition has any.
    pub restriction: Option<Restriction>,
    /// The values with a special meaning, including values that the restriction allows.
    pub special: Vec<Number>,
    /// The index of the array whose used entries this field counts, if there is one.
    pub counts: Option<usize>,
    /// The index of the field that contains the number of used entries, if there is one.
    pub counted_by: Option<usize>,
    /// The declaration; empty for a field without a definition.
    pub span: Span,
    pub(super) default: Option<Value>,
    pub(super) is_restricted: bool,
}

impl Named for Field {
    fn name(&self) -> &str {
        &self.name
    }
}

impl Field {
    /// The type.
    pub fn ty(&self) -> Type {
        Type { element: self.element, shape: self.shape }
    }

    /// The number of elements stored among the fields. The number is 0 for a sequence, because its elements follow the
    /// fields.
    pub fn count(&self) -> usize {
        match self.shape {
            Shape::Single => 1,
            Shape::Array(length) => length as usize,
            Shape::Bounded(_) | Shape::Sequence => 0,
        }
    }

    /// True if the number of elements varies.
    pub fn is_sequence(&self) -> bool {
        matches!(self.shape, Shape::Bounded(_) | Shape::Sequence)
    }

    /// Maximum number of elements of a sequence.
    pub(super) fn bound(&self) -> Option<u32> {
        match self.shape {
            Shape::Bounded(bound) => Some(bound),
            Shape::Single | Shape::Array(_) | Shape::Sequence => None,
        }
    }
}

/// Size of the slot for a string or sequence in its message. The slot contains two `u32` values: the offset of the
/// bytes or elements from the start of the buffer, and their count.
pub(crate) const SLOT: usize = 8;

/// Maximum ratio of memory size to CDR size. A message with one `uint8` is padded to eight bytes.
pub(super) const GROWTH: usize = 8;
