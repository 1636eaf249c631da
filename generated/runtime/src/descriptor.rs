//! Descriptors: compile-time data about messages. A descriptor contains the types, offsets and constraints of fields.
//! Generated code builds descriptors with the `const` functions of [`field`].
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

/// The descriptor of a message.
#[derive(Debug, PartialEq)]
pub struct MessageDescriptor {
    /// The name of the message.
    pub name: &'static str,
    /// The fields, in declaration order.
    pub fields: &'static [FieldDescriptor],
    /// Size in memory, if it is fixed.
    pub size: Option<Size>,
}

impl MessageDescriptor {
    /// A placeholder, used until the message is known.
    pub(crate) const NONE: Self = Self { name: "", fields: &[], size: None };

    /// Size in memory without the trailing padding, or 0 if the size varies.
    pub const fn no_padding(&self) -> usize {
        match self.size {
            Some(size) => size.no_padding,
            None => 0,
        }
    }

    /// Size in memory with the trailing padding, or 0 if the size varies.
    pub const fn padded_size(&self) -> usize {
        match self.size {
            Some(size) => size.padded,
            None => 0,
        }
    }
}

/// The descriptor of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldDescriptor {
    /// The name of the field.
    pub name: &'static str,
    /// Type of the field, or of its elements.
    pub element: Element,
    /// Number of elements.
    pub shape: Shape,
    /// Byte offset in memory, or 0 if the size of the message varies.
    pub offset: usize,
    /// The constraint on the value, or on each element.
    pub constraint: Option<&'static Constraint<'static>>,
}

/// The type of a field, or of the elements of an array.
#[derive(Clone, Copy, Debug)]
pub enum Element {
    /// A number, a `bool`, a `byte` or a `char`.
    Scalar(Scalar),
    /// Text: PX4's `char[N]`. The array length in the shape of the field is the size of the text in bytes.
    Text,
    /// A string.
    String {
        /// True for a `wstring`.
        is_wide: bool,
        /// Maximum number of characters.
        bound: Option<u32>,
    },
    /// A message.
    Message(&'static MessageDescriptor),
}

/// Two messages are equal if they have the same name; the fields are not compared.
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

/// The number of elements in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// One value.
    Single,
    /// An array of fixed length.
    Array(u32),
    /// A sequence with a maximum length.
    Bounded(u32),
    /// A sequence of any length.
    Sequence,
}

impl Shape {
    /// The maximum number of elements, if it is limited.
    pub const fn bound(self) -> Option<u32> {
        match self {
            Self::Single => Some(1),
            Self::Array(bound) | Self::Bounded(bound) => Some(bound),
            Self::Sequence => None,
        }
    }
}

impl FieldDescriptor {
    /// Makes the field an array of `length` elements.
    #[must_use]
    pub const fn array(mut self, length: u32) -> Self {
        self.shape = Shape::Array(length);
        self
    }

    /// Makes the field a sequence of at most `bound` elements.
    #[must_use]
    pub const fn bounded(mut self, bound: u32) -> Self {
        self.shape = Shape::Bounded(bound);
        self
    }

    /// Makes the field a sequence.
    #[must_use]
    pub const fn sequence(mut self) -> Self {
        self.shape = Shape::Sequence;
        self
    }

    /// Limits a string to `bound` characters.
    #[must_use]
    pub const fn at_most(mut self, bound: u32) -> Self {
        if let Element::String { is_wide, .. } = self.element {
            self.element = Element::String { is_wide, bound: Some(bound) };
        }
        self
    }

    /// Constrains the value, or each element.
    #[must_use]
    pub const fn within(mut self, constraint: &'static Constraint<'static>) -> Self {
        self.constraint = Some(constraint);
        self
    }
}

/// Constructors of field descriptors, named after the types of a `.msg` file.
pub mod field {
    use super::{Element, FieldDescriptor, Shape};
    use crate::record::Record;
    // These imports are private, because generated code imports the whole module next to its own types.
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

    /// A field of type `char[N]`: PX4's fixed-size text.
    pub const fn text(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::Text, offset)
    }

    /// A field of type `string`.
    pub const fn string(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::String { is_wide: false, bound: None }, offset)
    }

    /// A field of type `wstring`: a string of UTF-16 code units.
    pub const fn wstring(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::String { is_wide: true, bound: None }, offset)
    }

    /// A field that contains a message.
    pub const fn message<T: Record>(name: &'static str, offset: usize) -> FieldDescriptor {
        new(name, Element::Message(T::DESCRIPTOR), offset)
    }

    /// A constraint that allows any number. The methods of [`Constraint`] add restrictions.
    pub const fn number() -> Constraint<'static> {
        Constraint::NONE
    }

    /// An integer for a constraint.
    pub const fn int(value: i128) -> Number {
        Number::Int(value)
    }

    /// A float for a constraint.
    pub const fn float(value: f64) -> Number {
        Number::Float(value)
    }
}

#[cfg(test)]
mod tests {
    use super::{Element, Scalar};

    #[test]
    fn elements_are_equal_if_their_types_and_bounds_are() {
        let string = |is_wide, bound| Element::String { is_wide, bound };
        let all = [
            Element::Scalar(Scalar::Int8),
            Element::Scalar(Scalar::UInt8),
            Element::Text,
            string(false, None),
            string(true, None),
            string(false, Some(4)),
            string(false, Some(5)),
        ];
        for (at, left) in all.iter().enumerate() {
            for (other_at, right) in all.iter().enumerate() {
                assert_eq!(left == right, at == other_at, "{left:?} {right:?}");
            }
        }
    }
}
