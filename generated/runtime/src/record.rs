//! Messages as lists of fields, which is how codecs and checks see them.
//!
//! Generated code says once, for each message, how its fields go out ([`Record::write_fields`]) and
//! come in ([`Record::read_fields`]). Each format is a sink and a source that takes or gives one field after the
//! other. They keep the first fault and go on with zeros, so that generated code needs no `?` for
//! each field: that costs the compiler more than all else, and the processor a branch.
//!
//! ```
//! use uavspec_runtime::Scalar;
//! use uavspec_runtime::record::Primitive;
//!
//! assert_eq!(u16::SCALAR, Scalar::UInt16);
//! assert_eq!((u16::read_le(&[1, 2]), u16::read_be(&[1, 2])), (0x0201, 0x0102));
//! ```

use crate::descriptor::{FieldDescriptor, MessageDescriptor, Shape};
use crate::{Number, Scalar};

/// A message as a list of fields.
pub trait Record: Default + crate::JsonField + crate::SchemaRecord {
    /// What is known of its fields.
    const DESCRIPTOR: &'static MessageDescriptor;

    /// Gives each field to `sink`, in declared order.
    fn write_fields<S: FieldSink>(&self, sink: &mut S);

    /// Takes each field from `source`, in declared order.
    fn read_fields<S: FieldSource>(source: &mut S) -> Self;
}

/// Takes the fields of one message. The sink knows the message, so the compiler checks one argument less for each
/// field of each generated type.
pub trait FieldSink {
    /// Takes the field `index` of the message.
    fn field<T: Value>(&mut self, index: usize, value: &T);
}

/// Gives the fields of one message, which the source knows.
pub trait FieldSource {
    /// Gives the field `index` of the message.
    fn field<T: Value>(&mut self, index: usize) -> T;
}

/// Takes values in one format.
pub trait Sink: FieldSink {
    /// Takes a number.
    fn scalar<P: Primitive>(&mut self, value: P);

    /// Takes an array of numbers.
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        for (index, value) in values.iter().enumerate() {
            self.select(Some(index));
            self.scalar(*value);
        }
        self.select(None);
    }

    /// Takes text of fixed size.
    fn text(&mut self, bytes: &[u8]);

    /// Takes the length of a sequence.
    fn length(&mut self, length: usize, shape: Shape);

    /// Takes a string, of at most `bound` characters.
    fn string(&mut self, text: &str, is_wide: bool, bound: Option<u32>);

    /// Takes a message.
    fn message<M: Record>(&mut self, message: &M);

    /// Learns which element of an array comes next; none after the last.
    fn select(&mut self, element: Option<usize>);
}

/// Gives values in one format.
pub trait Source: FieldSource {
    /// Gives a number.
    fn scalar<P: Primitive>(&mut self) -> P;

    /// Gives an array of numbers.
    fn scalars<P: Primitive>(&mut self, values: &mut [P]);

    /// Gives the length of a sequence whose elements take at least `element_size` bytes each: no more
    /// than the bytes that are left can hold.
    fn length(&mut self, shape: Shape, element_size: usize) -> usize;

    /// Gives a string, of at most `bound` characters.
    #[cfg(feature = "alloc")]
    fn string(&mut self, is_wide: bool, bound: Option<u32>) -> alloc::string::String;

    /// Gives a message.
    fn message<M: Record>(&mut self) -> M;

    /// Whether there was a fault: all values from then on are zero.
    fn has_failed(&self) -> bool;

    /// Learns in which element of an array the first fault is.
    fn blame(&mut self, element: usize);
}

/// A value of a field.
pub trait Value: Sized + crate::JsonField {
    /// Least number of bytes that it takes in CDR, without alignment.
    const LEAST_SIZE: usize;

    /// What stands in a field until it is read: `Default`, which arrays of any length don't have.
    fn initial() -> Self;

    /// Gives itself to `sink`.
    fn write<S: Sink>(&self, sink: &mut S, field: &'static FieldDescriptor);

    /// Comes from `source`.
    fn read<S: Source>(source: &mut S, field: &'static FieldDescriptor) -> Self;

    /// Gives all values of an array.
    #[inline]
    fn write_all<S: Sink>(values: &[Self], sink: &mut S, field: &'static FieldDescriptor) {
        for (index, value) in values.iter().enumerate() {
            sink.select(Some(index));
            value.write(sink, field);
        }
        sink.select(None);
    }

    /// Takes all values of an array of fixed length.
    #[inline]
    fn read_array<S: Source, const N: usize>(source: &mut S, field: &'static FieldDescriptor) -> [Self; N] {
        // The compiler makes far better code of this than of an array whose maker reads.
        let mut values = core::array::from_fn(|_| Self::initial());
        for (index, value) in values.iter_mut().enumerate() {
            *value = element(source, index, field);
        }
        values
    }

    /// Takes all values of a sequence.
    #[cfg(feature = "alloc")]
    fn read_sequence<S: Source>(
        source: &mut S,
        length: usize,
        field: &'static FieldDescriptor,
    ) -> alloc::vec::Vec<Self> {
        let mut values = alloc::vec::Vec::new();
        for index in 0..length {
            let value = element(source, index, field);
            // A value that isn't there takes no room.
            if source.has_failed() {
                break;
            }
            values.push(value);
        }
        values
    }
}

#[inline]
fn element<T: Value, S: Source>(source: &mut S, index: usize, field: &'static FieldDescriptor) -> T {
    let had_failed = source.has_failed();
    let value = T::read(source, field);
    if !had_failed && source.has_failed() {
        source.blame(index);
    }
    value
}

/// A number of fixed size.
pub trait Primitive: Copy + Default + 'static {
    /// Its type; `byte` and `char` are `uint8`.
    const SCALAR: Scalar;

    /// Size in bytes, which is its alignment too.
    const SIZE: usize;

    /// The number that little-endian bytes hold; zero where there are too few.
    fn read_le(bytes: &[u8]) -> Self;

    /// The number that big-endian bytes hold; zero where there are too few.
    fn read_be(bytes: &[u8]) -> Self;

    /// Writes it little-endian to `bytes`, which have its size.
    fn write_le(self, bytes: &mut [u8]);

    /// Writes it big-endian to `bytes`, which have its size.
    fn write_be(self, bytes: &mut [u8]);

    /// The number, for checks.
    fn number(self) -> Number;

    /// Its bits, without any of its sign above them.
    #[inline]
    fn bits(self) -> u64 {
        let mut bytes = [0; 8];
        self.write_le(&mut bytes);
        u64::from_le_bytes(bytes)
    }

    /// The byte of a `bool` if it is neither 0 nor 1, given the bytes that it comes from.
    #[inline]
    fn odd_bool(_: &[u8]) -> Option<u8> {
        None
    }
}

macro_rules! primitives {
    ($($type:ident $number:ident $scalar:ident,)*) => {$(
        impl Primitive for $type {
            const SCALAR: Scalar = Scalar::$scalar;
            const SIZE: usize = size_of::<$type>();

            #[inline]
            fn read_le(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or_else(Self::default, |bytes| Self::from_le_bytes(*bytes))
            }

            #[inline]
            fn read_be(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or_else(Self::default, |bytes| Self::from_be_bytes(*bytes))
            }

            #[inline]
            fn write_le(self, bytes: &mut [u8]) {
                if let Some(bytes) = bytes.first_chunk_mut() {
                    *bytes = self.to_le_bytes();
                }
            }

            #[inline]
            fn write_be(self, bytes: &mut [u8]) {
                if let Some(bytes) = bytes.first_chunk_mut() {
                    *bytes = self.to_be_bytes();
                }
            }

            #[inline]
            fn number(self) -> Number {
                Number::$number(self.into())
            }
        }
    )*};
}

primitives!(
    u8 Int UInt8, i8 Int Int8, u16 Int UInt16, i16 Int Int16, u32 Int UInt32, i32 Int Int32, u64 Int UInt64,
    i64 Int Int64, f32 Float Float32, f64 Float Float64,
);

/// Any byte but 0 is true: real logs hold 153, 94 and 194.
impl Primitive for bool {
    const SCALAR: Scalar = Scalar::Bool;
    const SIZE: usize = 1;

    #[inline]
    fn read_le(bytes: &[u8]) -> Self {
        bytes.first().is_some_and(|byte| *byte != 0)
    }

    #[inline]
    fn read_be(bytes: &[u8]) -> Self {
        Self::read_le(bytes)
    }

    #[inline]
    fn write_le(self, bytes: &mut [u8]) {
        u8::from(self).write_le(bytes);
    }

    #[inline]
    fn write_be(self, bytes: &mut [u8]) {
        u8::from(self).write_le(bytes);
    }

    #[inline]
    fn number(self) -> Number {
        Number::Int(self.into())
    }

    #[inline]
    fn odd_bool(bytes: &[u8]) -> Option<u8> {
        bytes.first().copied().filter(|byte| *byte > 1)
    }
}

/// Implements the codecs of a message from its name, the number of its fields, and the fields: index, name and descriptor. A message of fixed size
/// has the name of its view and its two sizes too, and each field the type of its [`View`](crate::uorb::View).
#[macro_export]
macro_rules! record {
    ($type:ident[$count:literal], $view:ident, $size:literal, $no_padding:literal;
        $($index:literal $field:ident: $field_view:ty = $descriptor:expr;)*) => {
        $crate::__record!($type[$count], ::core::option::Option::Some($crate::layout::Size { padded: $size, no_padding: $no_padding });
            $($index $field $descriptor;)*);

        impl $crate::UorbMessage for $type {
            type Bytes = [u8; $size];
            type View<'b> = $view<'b>;

            #[inline]
            fn from_view(view: $view<'_>) -> Self {
                view.0.read()
            }
        }

        #[doc = concat!("A view of a payload that holds a [`", stringify!($type), "`]: a method reads the field of its name.")]
        #[derive(Clone, Copy)]
        pub struct $view<'b>($crate::uorb::Fields<'b, $type, $no_padding>);

        impl<'b> $view<'b> {
            $(
                /// Reads the field of this name.
                #[inline]
                pub fn $field(self) -> $field_view {
                    self.0.get($index)
                }
            )*
        }

        impl<'b> $crate::uorb::View<'b> for $view<'b> {
            const STRIDE: usize = $size;

            #[inline]
            fn at(bytes: &'b [u8], offset: usize) -> Self {
                Self($crate::uorb::Fields::at(bytes, offset))
            }
        }

        impl ::core::fmt::Debug for $view<'_> {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::core::fmt::Debug::fmt(&self.0, formatter)
            }
        }
    };
    ($type:ident[$count:literal]; $($index:literal $field:ident = $descriptor:expr;)*) => {
        $crate::__record!($type[$count], ::core::option::Option::None; $($index $field $descriptor;)*);
    };
}

/// The part of [`record!`](crate::record!) that messages of any size have.
#[doc(hidden)]
#[macro_export]
macro_rules! __record {
    ($type:ident[$count:literal], $size:expr; $($index:literal $field:ident $descriptor:expr;)*) => {
        impl $crate::record::Record for $type {
            const DESCRIPTOR: &'static $crate::descriptor::MessageDescriptor = {
                #[allow(unused_imports)]
                use $crate::descriptor::field::*;
                // A constant of its own: the compiler takes four times as long for a borrowed array.
                const FIELDS: [$crate::descriptor::FieldDescriptor; $count] = [$($descriptor),*];
                &$crate::descriptor::MessageDescriptor { name: stringify!($type), fields: &FIELDS, size: $size }
            };

            #[inline(always)]
            fn write_fields<S: $crate::record::FieldSink>(&self, sink: &mut S) {
                $(sink.field($index, &self.$field);)*
            }

            #[inline(always)]
            fn read_fields<S: $crate::record::FieldSource>(source: &mut S) -> Self {
                Self { $($field: source.field($index)),* }
            }
        }

        $crate::__json_record!($type; $($index $field)*);
        $crate::__arbitrary_record!($type);
        $crate::__schema_record!($type);
    };
}
