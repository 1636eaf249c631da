//! The compiled form of a type, for codecs and checks.

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::Size;
use uavspec_schema::value::Value;
use uavspec_schema::{Restriction, Shape};

use super::error::Defect;
use super::members::Named;
use super::packed::Packed;
use super::step::{Bounds, Step};

/// A compiled message type.
#[derive(Debug)]
#[allow(clippy::struct_excessive_bools)] // the flags are independent
pub(super) struct Plan {
    pub(super) package: Box<str>,
    pub(super) name: Box<str>,
    /// Fields in declaration order.
    pub(super) fields: Box<[Field]>,
    /// Size of the fixed part, which is the whole message if `is_fixed`.
    pub(super) size: Size,
    /// True if the message contains no strings and no sequences.
    pub(super) is_fixed: bool,
    /// Minimum CDR size in bytes, without alignment padding.
    pub(super) min: usize,
    /// Conversion steps between memory and CDR, in CDR order.
    pub(super) steps: Box<[Step]>,
    /// Copy operations for the whole message, if its size is fixed and the number of operations is within the limit.
    pub(super) packed: Option<Packed>,
    /// True if any field, including fields of nested messages, has a nonzero default.
    pub(super) has_defaults: bool,
    /// True if any field, including fields of nested messages, is a `bool`.
    pub(super) has_bools: bool,
    /// True if the message can contain a value that violates a rule.
    pub(super) is_restricted: bool,
    /// The reason why the type is unusable.
    pub(super) defect: Option<Defect>,
}

#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: Box<str>,
    pub(super) element: Element,
    pub(super) shape: Shape,
    /// Byte offset in the message.
    pub(super) offset: usize,
    /// Distance between elements in bytes.
    pub(super) stride: usize,
    pub(super) default: Option<Value>,
    pub(super) restriction: Option<Restriction>,
    pub(super) is_restricted: bool,
}

impl Named for Field {
    fn name(&self) -> &str {
        &self.name
    }
}

impl Field {
    /// The number of elements stored among the fields. This is 0 for a sequence, because its elements follow the
    /// fields.
    pub(super) fn count(&self) -> usize {
        match self.shape {
            Shape::Single => 1,
            Shape::Array(length) => length as usize,
            Shape::Bounded(_) | Shape::Sequence => 0,
        }
    }

    /// True if the number of elements varies.
    pub(super) fn is_sequence(&self) -> bool {
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

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Element {
    Scalar(Scalar),
    /// PX4's `char[N]`, treated as one text of `N` bytes.
    Text(u32),
    String(Bounds),
    /// A message; the value is the index of its plan.
    Message(usize),
}

impl Element {
    pub(super) fn is_bool(self) -> bool {
        self == Self::Scalar(Scalar::Bool)
    }
}

/// Size of the slot for a string or sequence in its message. The slot contains two `u32` values: the offset of the
/// bytes or elements from the start of the buffer, and their count.
pub(crate) const SLOT: usize = 8;

/// Maximum ratio of memory size to CDR size. A message with one `uint8` is padded to eight bytes.
pub(super) const GROWTH: usize = 8;
