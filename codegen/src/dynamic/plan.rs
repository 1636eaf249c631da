//! What a type's codecs and checks need to know, worked out once.

use uavspec_runtime::Scalar;
use uavspec_runtime::layout::Size;

use super::error::Defect;
use super::members::Named;
use super::packed::Packed;
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

/// What a string may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// Whether it is a `wstring`.
    pub(super) is_wide: bool,
    /// Greatest number of characters.
    pub(super) bound: Option<u32>,
}

impl Bounds {
    /// Whether text, which is UTF-8, has too many characters.
    pub(super) fn exceeded_by(self, text: &[u8]) -> bool {
        let is_start = |byte: &&u8| **byte & 0xc0 != 0x80;
        self.bound.is_some_and(|bound| {
            let bound = bound as usize;
            text.len() > bound && text.iter().filter(is_start).count() > bound
        })
    }
}

/// A step between memory and CDR. Offsets are bytes from the start of the message in memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// Numbers that lie side by side in both.
    Copy(Run),
    /// Strings.
    Strings { offset: usize, count: usize, bounds: Bounds },
    /// Messages.
    Messages { offset: usize, count: usize, plan: usize },
    /// A sequence.
    Sequence { offset: usize, bound: Option<u32>, element: Sequence },
    /// The byte that stands for a message without fields.
    Empty,
}

/// Numbers of one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) offset: usize,
    /// Size of all of them in bytes.
    pub(super) size: usize,
    pub(super) width: Width,
    pub(super) is_bool: bool,
}

/// Size of a number in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    One = 1,
    Two = 2,
    Four = 4,
    Eight = 8,
}

impl Width {
    pub(super) fn of(scalar: Scalar) -> Self {
        match scalar.size() {
            1 => Self::One,
            2 => Self::Two,
            4 => Self::Four,
            _ => Self::Eight,
        }
    }
}

/// What a sequence holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sequence {
    Numbers { width: Width, is_bool: bool },
    Strings(Bounds),
    Messages(usize),
}

/// Bytes that a string or sequence takes in the message that holds it: where its bytes or elements
/// start, from the start of the buffer, and how many there are, each a `u32`.
pub(super) const SLOT: usize = 8;
