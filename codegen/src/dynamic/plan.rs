//! What a type's codecs and checks need to know, worked out once.

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::Size;

use super::error::Defect;
use super::members::Named;
use super::packed::Packed;
use super::step::{Bounds, Step};
use crate::schema::{Restriction, Shape};
use crate::value::Value;

/// A type of messages.
#[derive(Debug)]
#[allow(clippy::struct_excessive_bools)] // each is a fact of its own
pub(super) struct Plan {
    pub(super) package: Box<str>,
    pub(super) name: Box<str>,
    /// Fields in declared order.
    pub(super) fields: Box<[Field]>,
    /// Size of the part that has a fixed size, which is all of it where `is_fixed`.
    pub(super) size: Size,
    /// Whether there are neither strings nor sequences in it.
    pub(super) is_fixed: bool,
    /// Least number of bytes in CDR, without what aligns them.
    pub(super) least: usize,
    /// The way between memory and CDR, in the order of CDR.
    pub(super) steps: Box<[Step]>,
    /// The same of a whole message of fixed size, where it isn't too long.
    pub(super) packed: Option<Packed>,
    /// Whether a field has a default, or one of a message in it.
    pub(super) has_defaults: bool,
    /// Whether a field is a `bool`, or one of a message in it.
    pub(super) has_bools: bool,
    /// Whether a rule can be broken in it.
    pub(super) is_restricted: bool,
    /// Why it can't be used.
    pub(super) defect: Option<Defect>,
}

#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: Box<str>,
    pub(super) element: Element,
    pub(super) shape: Shape,
    /// First byte in memory, from the start of the message.
    pub(super) offset: usize,
    /// Bytes from one element to the next.
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
    /// The number of elements that stand in the message itself: of a sequence, none do.
    pub(super) fn count(&self) -> usize {
        match self.shape {
            Shape::Single => 1,
            Shape::Array(length) => length as usize,
            Shape::Bounded(_) | Shape::Sequence => 0,
        }
    }

    /// Whether the number of elements varies.
    pub(super) fn is_sequence(&self) -> bool {
        matches!(self.shape, Shape::Bounded(_) | Shape::Sequence)
    }

    /// The greatest number of elements of a sequence.
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
    /// PX4's `char[N]` as a whole, of so many bytes.
    Text(u32),
    String(Bounds),
    /// The message of the plan with this index.
    Message(usize),
}

impl Element {
    pub(super) fn is_bool(self) -> bool {
        self == Self::Scalar(Scalar::Bool)
    }
}

/// Bytes that a string or sequence takes in the message that holds it: where its bytes or elements
/// start, from the start of the buffer, and how many there are, each a `u32`.
pub(super) const SLOT: usize = 8;

/// Most bytes that a byte of CDR takes in memory: a message of one `uint8` is padded to so many.
pub(super) const GROWTH: usize = 8;
