//! Messages as lists of fields: the interface between messages on one side, and codecs and checks on the other.
//!
//! Each generated message implements [`Record::write_fields`] and [`Record::read_fields`] once. Each format implements
//! a sink, which receives the fields, and a source, which returns them. Sinks and sources store the first fault, and a
//! source returns zeros after a fault. Generated code therefore needs no `?` for each field, which would cost compile
//! time and a branch.
//!
//! ```
//! use uavspec_runtime::Scalar;
//! use uavspec_runtime::record::Primitive;
//!
//! assert_eq!(u16::SCALAR, Scalar::UInt16);
//! assert_eq!((u16::read_le(&[1, 2]), u16::read_be(&[1, 2])), (0x0201, 0x0102));
//! ```

use core::fmt;

use crate::descriptor::{FieldDescriptor, MessageDescriptor, Shape};
use crate::{Number, Scalar};

/// A message as a list of fields.
pub trait Record: Default + fmt::Debug + crate::JsonField + crate::SchemaRecord {
    /// The descriptor of the message.
    const DESCRIPTOR: &'static MessageDescriptor;

    /// Writes each field to `sink`, in declaration order.
    fn write_fields<S: FieldSink>(&self, sink: &mut S);

    /// Reads each field from `source`, in declaration order.
    fn read_fields<S: FieldSource>(source: &mut S) -> Self;
}

/// A sink for the fields of one message. The sink stores the message descriptor, so generated code passes one argument
/// fewer per field and compiles faster.
pub trait FieldSink {
    /// Writes the field with this index.
    fn field<T: Value>(&mut self, index: usize, value: &T);
}

/// A source for the fields of one message.
pub trait FieldSource {
    /// Reads the field with this index.
    fn field<T: Value>(&mut self, index: usize) -> T;
}

/// Adds each field to a formatted struct.
struct DebugFields<'f, 'b> {
    message: &'static MessageDescriptor,
    out: fmt::DebugStruct<'f, 'b>,
}

impl FieldSink for DebugFields<'_, '_> {
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        self.out.field(self.message.fields[index].name, value);
    }
}

/// Formats a message as the derived `Debug` does, except that fields have their names in the definition. The derive would
/// take longer to compile, because it generates code for each field.
#[doc(hidden)]
pub fn debug<M: Record>(message: &M, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
    let out = formatter.debug_struct(M::DESCRIPTOR.name);
    let mut fields = DebugFields { message: M::DESCRIPTOR, out };
    message.write_fields(&mut fields);
    fields.out.finish()
}

/// A sink for values in one format.
pub trait Sink: FieldSink {
    /// Writes a number.
    fn scalar<P: Primitive>(&mut self, value: P);

    /// Writes an array of numbers.
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        for (index, value) in values.iter().enumerate() {
            self.select(Some(index));
            self.scalar(*value);
        }
        self.select(None);
    }

    /// Writes fixed-size text.
    fn text(&mut self, bytes: &[u8]);

    /// Writes the length of a sequence.
    fn length(&mut self, length: usize, shape: Shape);

    /// Writes a string of at most `bound` characters.
    fn string(&mut self, text: &str, is_wide: bool, bound: Option<u32>);

    /// Writes a message.
    fn message<M: Record>(&mut self, message: &M);

    /// Sets the index of the next array element, or `None` after the last element.
    fn select(&mut self, element: Option<usize>);
}

/// A source for values in one format.
pub trait Source: FieldSource {
    /// Reads a number.
    fn scalar<P: Primitive>(&mut self) -> P;

    /// Reads an array of numbers.
    fn scalars<P: Primitive>(&mut self, values: &mut [P]);

    /// Reads the length of a sequence whose elements take at least `element_size` bytes each. Ensures that enough bytes
    /// remain for that many elements.
    fn length(&mut self, shape: Shape, element_size: usize) -> usize;

    /// Reads a string of at most `bound` characters.
    #[cfg(feature = "alloc")]
    fn string(&mut self, is_wide: bool, bound: Option<u32>) -> alloc::string::String;

    /// Reads a message.
    fn message<M: Record>(&mut self) -> M;

    /// True if there was a fault. All values after the fault are zero.
    fn has_failed(&self) -> bool;

    /// Adds the index of the array element to the location of the first fault.
    fn locate_fault(&mut self, element: usize);
}

/// A field value.
pub trait Value: Sized + fmt::Debug + crate::JsonField {
    /// The minimum CDR size in bytes, without alignment padding.
    const LEAST_SIZE: usize;

    /// The initial value, before reading. Replaces `Default`, which arrays of arbitrary length don't implement.
    fn initial() -> Self;

    /// Writes the value to `sink`.
    fn write<S: Sink>(&self, sink: &mut S, field: &'static FieldDescriptor);

    /// Reads a value from `source`.
    fn read<S: Source>(source: &mut S, field: &'static FieldDescriptor) -> Self;

    /// Writes all values of an array.
    #[inline]
    fn write_all<S: Sink>(values: &[Self], sink: &mut S, field: &'static FieldDescriptor) {
        for (index, value) in values.iter().enumerate() {
            sink.select(Some(index));
            value.write(sink, field);
        }
        sink.select(None);
    }

    /// Reads all values of an array of fixed length.
    #[inline]
    fn read_array<S: Source, const N: usize>(source: &mut S, field: &'static FieldDescriptor) -> [Self; N] {
        // This compiles to much better code than `array::from_fn` with a closure that reads.
        let mut values = core::array::from_fn(|_| Self::initial());
        for (index, value) in values.iter_mut().enumerate() {
            *value = element(source, index, field);
        }
        values
    }

    /// Reads all values of a sequence.
    #[cfg(feature = "alloc")]
    fn read_sequence<S: Source>(
        source: &mut S,
        length: usize,
        field: &'static FieldDescriptor,
    ) -> alloc::vec::Vec<Self> {
        let mut values = alloc::vec::Vec::new();
        for index in 0..length {
            let value = element(source, index, field);
            // After a fault, don't allocate memory for the remaining values.
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
        source.locate_fault(index);
    }
    value
}

/// A fixed-size number.
pub trait Primitive: Copy + Default + 'static {
    /// The scalar type. `byte` and `char` count as `uint8`.
    const SCALAR: Scalar;

    /// Size in bytes, which is also the alignment.
    const SIZE: usize;

    /// Reads a little-endian number, or zero if there are too few bytes.
    fn read_le(bytes: &[u8]) -> Self;

    /// Reads a big-endian number, or zero if there are too few bytes.
    fn read_be(bytes: &[u8]) -> Self;

    /// Writes the number to `bytes` in little-endian order.
    fn write_le(self, bytes: &mut [u8]);

    /// Writes the number to `bytes` in big-endian order.
    fn write_be(self, bytes: &mut [u8]);

    /// The value as the number type that checks use.
    fn number(self) -> Number;

    /// The bits of the number, without sign extension.
    #[inline]
    fn bits(self) -> u64 {
        let mut bytes = [0; 8];
        self.write_le(&mut bytes);
        u64::from_le_bytes(bytes)
    }

    /// The byte of a `bool` that is neither 0 nor 1. `None` for valid bytes and for other types.
    #[inline]
    fn invalid_bool(_: &[u8]) -> Option<u8> {
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

/// Any byte other than 0 is true: real logs contain the bytes 153, 94 and 194.
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
    fn invalid_bool(bytes: &[u8]) -> Option<u8> {
        bytes.first().copied().filter(|byte| *byte > 1)
    }
}

/// Implements the codecs of a message, and `Debug`, which must not be derived as well. The arguments are the message
/// name, the number of fields, and the index, name and descriptor of each field.
///
/// For a fixed-size message, the arguments also include the name of its view, the size with padding and the size
/// without padding. For each field, the arguments also include the type that the view returns.
#[macro_export]
macro_rules! record {
    ($type:ident[$count:literal], $view:ident, $size:literal, $no_padding:literal;
        $($index:literal $field:ident: $field_view:ty = $descriptor:expr;)*) => {
        $crate::__record!($type[$count], ::core::option::Option::Some($crate::layout::Size { padded: $size, no_padding: $no_padding });
            $($index $field $descriptor;)*);

        impl $crate::UorbMessage for $type {
            type Bytes = [u8; $size];
            $crate::__view_items!($view);
        }

        $crate::__view! { $type $view $size $no_padding; $($index $field $field_view;)* }
    };
    ($type:ident[$count:literal]; $($index:literal $field:ident = $descriptor:expr;)*) => {
        $crate::__record!($type[$count], ::core::option::Option::None; $($index $field $descriptor;)*);
    };
}

/// The part of [`record!`](crate::record!) that fixed-size and variable-size messages share.
#[doc(hidden)]
#[macro_export]
macro_rules! __record {
    ($type:ident[$count:literal], $size:expr; $($index:literal $field:ident $descriptor:expr;)*) => {
        impl $crate::record::Record for $type {
            const DESCRIPTOR: &'static $crate::descriptor::MessageDescriptor = {
                #[allow(unused_imports)]
                use $crate::descriptor::field::*;
                // A separate constant compiles in a quarter of the time that a borrowed array takes.
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

        impl ::core::fmt::Debug for $type {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                $crate::record::debug(self, formatter)
            }
        }

        $crate::__json_record!($type[$count]; $($index $field)*);
        $crate::__arbitrary_record!($type);
        $crate::__schema_record!($type);
    };
}
