//! What is known of a message while compiling, as data: the types of its fields, where they lie, and
//! what their values may be. Generated code builds it with the `const` functions of [`field`].
//!
//! ```
//! use uavspec_runtime::descriptor::{Element, FieldDescriptor, Shape, field};
//! use uavspec_runtime::Scalar;
//!
//! const CELLS: FieldDescriptor = field::float32("cells", 8).array(14);
//! assert_eq!((CELLS.name, CELLS.offset, CELLS.shape), ("cells", 8, Shape::Array(14)));
//! assert_eq!(CELLS.element, Element::Scalar(Scalar::Float32));
//! ```

use crate::layout::Size;
use crate::{Constraint, Scalar};

/// A message.
#[derive(Debug, PartialEq)]
pub struct MessageDescriptor {
    /// Its name.
    pub name: &'static str,
    /// Its fields, in declared order.
    pub fields: &'static [FieldDescriptor],
    /// Its size in memory, where it is fixed.
    pub size: Option<Size>,
}

impl MessageDescriptor {
    /// No message: what stands where none is known yet.
    pub(crate) const NONE: Self = Self { name: "", fields: &[], size: None };

    /// Its size in memory without the padding at its end; 0 where that varies.
    pub const fn no_padding(&self) -> usize {
        match self.size {
            Some(size) => size.no_padding,
            None => 0,
        }
    }

    /// Its size in memory with the padding at its end; 0 where that varies.
    pub const fn padded_size(&self) -> usize {
        match self.size {
            Some(size) => size.padded,
            None => 0,
        }
    }
}

/// A field of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldDescriptor {
    /// Its name.
    pub name: &'static str,
    /// Type of the field, or of its elements.
    pub element: Element,
    /// How many elements it has.
    pub shape: Shape,
    /// Its first byte in memory; 0 where the size of the message varies.
    pub offset: usize,
    /// What its value may be, or that of each element, where the type says too little.
    pub constraint: Option<&'static Constraint<'static>>,
}

/// Type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug)]
pub enum Element {
    /// A number, a `bool`, a `byte` or a `char`.
    Scalar(Scalar),
    /// PX4's `char[N]` as a whole: as many bytes of text as the shape says.
    Text,
    /// A string.
    String {
        /// Whether it is a `wstring`.
        is_wide: bool,
        /// Greatest number of characters.
        bound: Option<u32>,
    },
    /// A message.
    Message(&'static MessageDescriptor),
}

/// Messages are equal that have the same name: a comparison of all that they nest says no more.
impl PartialEq for Element {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Scalar(left), Self::Scalar(right)) => left == right,
            (Self::Text, Self::Text) => true,
            (
                Self::String { is_wide, bound },
                Self::String { is_wide: other_is_wide, bound: other_bound },
            ) => is_wide == other_is_wide && bound == other_bound,
            (Self::Message(left), Self::Message(right)) => left.name == right.name,
            _ => false,
        }
    }
}

/// How many elements a field has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// One value.
    Single,
    /// Always so many.
    Array(u32),
    /// At most so many.
    Bounded(u32),
    /// Any number.
    Sequence,
}

impl Shape {
    /// The greatest number of elements, where there is one.
    pub const fn bound(self) -> Option<u32> {
        match self {
            Self::Single => Some(1),
            Self::Array(bound) | Self::Bounded(bound) => Some(bound),
            Self::Sequence => None,
        }
    }
}

impl FieldDescriptor {
    /// An array of `length` elements.
    #[must_use]
    pub const fn array(mut self, length: u32) -> Self {
        self.shape = Shape::Array(length);
        self
    }

    /// A sequence of at most `bound` elements.
    #[must_use]
    pub const fn bounded(mut self, bound: u32) -> Self {
        self.shape = Shape::Bounded(bound);
        self
    }

    /// A sequence.
    #[must_use]
    pub const fn sequence(mut self) -> Self {
        self.shape = Shape::Sequence;
        self
    }

    /// A string of at most `bound` characters.
    #[must_use]
    pub const fn at_most(mut self, bound: u32) -> Self {
        if let Element::String { is_wide, .. } = self.element {
            self.element = Element::String { is_wide, bound: Some(bound) };
        }
        self
    }

    /// A value, or elements, that keep to `constraint`.
    #[must_use]
    pub const fn within(mut self, constraint: &'static Constraint<'static>) -> Self {
        self.constraint = Some(constraint);
        self
    }
}

/// Makers of fields, called like the types of a `.msg` file.
pub mod field {
    use super::{Element, FieldDescriptor, Shape};
    use crate::record::Record;
    // Not public: generated code imports all of this module next to its types.
    use crate::{Constraint, Number, Scalar};

    const fn new(name: &'static str, element: Element, offset: usize) -> FieldDescriptor {
        FieldDescriptor { name, element, shape: Shape::Single, offset, constraint: None }
    }

    macro_rules! scalars {
        ($($function:ident $scalar:ident)*) => {$(
            #[doc = concat!("A field of type `", stringify!($function), "`.")]
            pub const fn $function(name: &'static str, offset: usize) -> FieldDescriptor {
                new(name, Element::Scalar(Scalar::$scalar), offset)
            }
        )*};
    }

    scalars!(
        bool Bool byte Byte char Char int8 Int8 uint8 UInt8 int16 Int16 uint16 UInt16 int32 Int32 uint32 UInt32
        int64 Int64 uint64 UInt64 float32 Float32 float64 Float64
    );

    /// PX4's text of fixed size, `char[N]`.
    pub const fn text(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::Text, offset)
    }

    /// A string.
    pub const fn string(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::String { is_wide: false, bound: None }, offset)
    }

    /// A string of 16-bit characters.
    pub const fn wstring(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::String { is_wide: true, bound: None }, offset)
    }

    /// A message.
    pub const fn message<T: Record>(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::Message(T::DESCRIPTOR), offset)
    }

    /// Any number, to be narrowed.
    pub const fn number() -> Constraint<'static> {
        Constraint::NONE
    }

    /// An integer.
    pub const fn int(value: i128) -> Number {
        Number::Int(value)
    }

    /// A float.
    pub const fn float(value: f64) -> Number {
        Number::Float(value)
    }
}
