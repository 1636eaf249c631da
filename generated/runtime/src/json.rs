//! The JSON form of messages, through serde. The published schemas describe this form.
//!
//! A message is an object with all fields in declaration order. NaN is `null`. Infinity has no JSON form: writing it is
//! an error that names the field. PX4's `char[N]` is a string.
//!
//! Reading accepts the fields in any order, and rejects missing, repeated and unknown fields. Integers have no
//! fraction: reading rejects `1.0`, although JSON Schema accepts it as the integer 1. Reading accepts sequences and
//! strings that exceed their bounds; [`validate`](crate::Message::validate) reports them.
//!
//! This code compiles faster than serde's derive, because it generates less code for each message. Keys usually arrive
//! in declaration order, so reading normally compares one name per field.
//!
//! ```
//! # use uavspec_runtime::{Definition, Message, record};
//! # #[derive(Clone, Default, PartialEq)]
//! # struct Wind {
//! #     speed: f32,
//! # }
//! # impl Message for Wind {
//! #     const DEFINITION: Definition = Definition::new("example", "Wind");
//! # }
//! # record! {
//! #     Wind[1];
//! #     0 speed = float32("speed", 0).within(&number().from(int(0)).not_nan());
//! # }
//! # #[cfg(feature = "json")] {
//! let text = r#"{"speed": 1.5}"#;
//! let wind: Wind = serde_json::from_str(text).expect("a wind");
//! assert_eq!(wind.speed, 1.5);
//! assert!(serde_json::from_str::<Wind>("{}").is_err());
//! # }
//! ```

#[cfg(feature = "alloc")]
use alloc::vec::Vec;
use core::fmt;
use core::marker::PhantomData;
use core::mem;

use serde::de::{DeserializeSeed, Error as _, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::ser::{Error as _, SerializeStruct, SerializeTuple as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::Text;
use crate::descriptor::MessageDescriptor;
use crate::record::{FieldSink, Record, Value};

/// A message whose fields can be read one by one, by index.
#[doc(hidden)]
pub trait Fields: Record + Default {
    /// An array with one element per field.
    type PerField: PerField<Self>;
    /// The names of the fields, in declaration order.
    const NAMES: &'static [&'static str] = <Self::PerField as PerField<Self>>::NAMES;

    /// Reads the field with this index, if there is one.
    fn read_field<'de, S: Source<'de>>(&mut self, index: usize, source: &mut S);
}

/// The constants of messages that depend on the number of fields. The compiler evaluates them only for messages that are
/// read or written as JSON, so other messages compile faster.
#[doc(hidden)]
pub trait PerField<T> {
    /// The names of the fields, in declaration order.
    const NAMES: &'static [&'static str];
    /// The fields that have been read.
    type Seen: AsMut<[bool]>;
    /// No field has been read.
    const UNSEEN: Self::Seen;
}

impl<T: Record, const N: usize> PerField<T> for [(); N] {
    type Seen = [bool; N];

    const NAMES: &'static [&'static str] = &names::<N>(T::DESCRIPTOR);
    const UNSEEN: [bool; N] = [false; N];
}

const fn names<const N: usize>(message: &MessageDescriptor) -> [&'static str; N] {
    let mut names = [""; N];
    let mut index = 0;
    while index < N {
        names[index] = message.fields[index].name;
        index += 1;
    }
    names
}

/// A field value with a JSON form.
#[doc(hidden)]
pub trait Field: Sized {
    /// Writes the value. Error messages contain the name `field`.
    fn serialize<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error>;

    /// Reads a value.
    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

/// A source of values: the members of an object, or the elements of a sequence. The source stores the error of a value,
/// so generated code needs no `Result` for each field and compiles faster.
#[doc(hidden)]
pub trait Source<'de> {
    /// Reads the next value into `field`, which stays unchanged after an error.
    fn read<T: Field>(&mut self, field: &mut T);
}

/// Writes fields until the first error, which it stores.
struct Writer<S: SerializeStruct> {
    message: &'static MessageDescriptor,
    out: S,
    error: Option<S::Error>,
}

impl<S: SerializeStruct> FieldSink for Writer<S> {
    #[inline]
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        let name = self.message.fields[index].name;
        if self.error.is_none()
            && let Err(error) = self.out.serialize_field(name, &Named { name, value })
        {
            self.error = Some(error);
        }
    }
}

/// Writes a message.
#[doc(hidden)]
pub fn serialize<T: Fields, S: Serializer>(record: &T, serializer: S) -> Result<S::Ok, S::Error> {
    let out = serializer.serialize_struct(T::DESCRIPTOR.name, T::NAMES.len())?;
    let mut writer = Writer { message: T::DESCRIPTOR, out, error: None };
    record.write_fields(&mut writer);
    match writer.error {
        None => writer.out.end(),
        Some(error) => Err(error),
    }
}

/// Reads a message.
#[doc(hidden)]
pub fn deserialize<'de, T: Fields, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let visitor = RecordVisitor { is_human_readable: deserializer.is_human_readable(), marker: PhantomData };
    deserializer.deserialize_struct(T::DESCRIPTOR.name, T::NAMES, visitor)
}

struct Named<'v, T> {
    name: &'static str,
    value: &'v T,
}

impl<T: Field> Serialize for Named<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(self.name, serializer)
    }
}

struct RecordVisitor<T> {
    /// True for a text format. In text formats, a message is always an object, never a list.
    is_human_readable: bool,
    marker: PhantomData<T>,
}

impl<'de, T: Fields> Visitor<'de> for RecordVisitor<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "an object with the fields of {}", T::DESCRIPTOR.name)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        let mut record = T::default();
        let mut source = Members { map, error: None };
        // Fast path: while the fields arrive in declaration order, no field can be repeated.
        let mut read = 0;
        let next = loop {
            let next = source.map.next_key_seed(KeySeed::<T>(read, PhantomData))?;
            if next != Some(read) {
                break next;
            }
            source.read_field(&mut record, read)?;
            read += 1;
        };
        if next.is_none() && read == T::NAMES.len() {
            return Ok(record);
        }
        read_in_any_order(record, read, next, source)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<T, A::Error> {
        if self.is_human_readable {
            return Err(A::Error::invalid_type(Unexpected::Seq, &self));
        }
        let mut record = T::default();
        let mut source = Elements { seq, error: None };
        for index in 0..T::NAMES.len() {
            record.read_field(index, &mut source);
        }
        source.error.map_or(Ok(record), Err)
    }
}

/// Reads the remaining fields in any order, starting with the field `next`. The first `read` fields have already been
/// read.
#[cold]
fn read_in_any_order<'de, T: Fields, A: MapAccess<'de>>(
    mut record: T,
    read: usize,
    mut next: Option<usize>,
    mut source: Members<'de, A>,
) -> Result<T, A::Error> {
    let mut seen = Seen::<T>::first(read);
    while let Some(index) = next {
        if !seen.insert(index) {
            return Err(A::Error::duplicate_field(T::NAMES[index]));
        }
        source.read_field(&mut record, index)?;
        next = source.map.next_key_seed(KeySeed::<T>(index + 1, PhantomData))?;
    }
    match (0..T::NAMES.len()).find(|index| seen.insert(*index)) {
        None => Ok(record),
        Some(missing) => Err(A::Error::missing_field(T::NAMES[missing])),
    }
}

/// The set of fields that have been read.
struct Seen<T: Fields>(<T::PerField as PerField<T>>::Seen);

impl<T: Fields> Seen<T> {
    /// The set of the first `count` fields.
    fn first(count: usize) -> Self {
        let mut seen = Self(<T::PerField as PerField<T>>::UNSEEN);
        seen.0.as_mut().iter_mut().take(count).for_each(|field| *field = true);
        seen
    }

    /// Adds a field. Returns true if the field was not in the set.
    fn insert(&mut self, index: usize) -> bool {
        self.0.as_mut().get_mut(index).is_some_and(|field| !mem::replace(field, true))
    }
}

struct Members<'de, A: MapAccess<'de>> {
    map: A,
    error: Option<A::Error>,
}

impl<'de, A: MapAccess<'de>> Members<'de, A> {
    #[inline]
    fn read_field<T: Fields>(&mut self, record: &mut T, index: usize) -> Result<(), A::Error> {
        record.read_field(index, self);
        self.error.take().map_or(Ok(()), Err)
    }
}

impl<'de, A: MapAccess<'de>> Source<'de> for Members<'de, A> {
    #[inline]
    fn read<T: Field>(&mut self, field: &mut T) {
        match self.map.next_value_seed(FieldSeed(PhantomData)) {
            Ok(value) => *field = value,
            Err(error) => self.error = Some(error),
        }
    }
}

struct Elements<'de, A: SeqAccess<'de>> {
    seq: A,
    error: Option<A::Error>,
}

impl<'de, A: SeqAccess<'de>> Source<'de> for Elements<'de, A> {
    fn read<T: Field>(&mut self, field: &mut T) {
        // After an error, nothing more is read.
        if self.error.is_some() {
            return;
        }
        match self.seq.next_element_seed(FieldSeed(PhantomData)) {
            Ok(Some(value)) => *field = value,
            Ok(None) => {
                let problem = "expected another field, found the end of the sequence";
                self.error = Some(A::Error::custom(problem));
            }
            Err(error) => self.error = Some(error),
        }
    }
}

struct FieldSeed<T>(PhantomData<T>);

impl<'de, T: Field> DeserializeSeed<'de> for FieldSeed<T> {
    type Value = T;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        T::deserialize(deserializer)
    }
}

/// Reads a key as the index of the named field. Compares the key with the field at the given index first.
struct KeySeed<T>(usize, PhantomData<T>);

impl<'de, T: Fields> DeserializeSeed<'de> for KeySeed<T> {
    type Value = usize;

    #[inline]
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<T: Fields> Visitor<'_> for KeySeed<T> {
    type Value = usize;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a field name")
    }

    // Not inlined, which keeps the caller small enough to be inlined into the loop over the fields.
    #[inline(never)]
    fn visit_str<E: serde::de::Error>(self, key: &str) -> Result<usize, E> {
        match T::NAMES.get(self.0) {
            Some(name) if *name == key => Ok(self.0),
            _ => find(T::NAMES, key),
        }
    }

    fn visit_u64<E: serde::de::Error>(self, index: u64) -> Result<usize, E> {
        let found = usize::try_from(index).ok().filter(|index| *index < T::NAMES.len());
        found.ok_or_else(|| E::custom(format_args!("field index {index} is out of range")))
    }
}

#[cold]
fn find<E: serde::de::Error>(names: &'static [&'static str], key: &str) -> Result<usize, E> {
    let found = names.iter().position(|name| *name == key);
    found.ok_or_else(|| E::unknown_field(key, names))
}

/// Implements `Field` by calling serde's implementation for the type.
macro_rules! plain_fields {
    ($($type:ty),*) => {
        $(impl Field for $type {
            fn serialize<S: Serializer>(&self, _: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
                Serialize::serialize(self, serializer)
            }

            fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                Deserialize::deserialize(deserializer)
            }
        })*
    };
}

plain_fields!(bool, i8, u8, i16, u16, i32, u32, i64, u64);

#[cfg(feature = "alloc")]
plain_fields!(alloc::string::String);

impl<T: Fields> Field for T {
    fn serialize<S: Serializer>(&self, _: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        serialize(self, serializer)
    }

    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserialize(deserializer)
    }
}

/// Implements `Field` for floats. In text formats, NaN is `null` and infinity is an error. Binary formats support NaN
/// and infinity.
macro_rules! float_fields {
    ($($type:ty),*) => {
        $(impl Field for $type {
            fn serialize<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
                if !serializer.is_human_readable() || self.is_finite() {
                    Serialize::serialize(self, serializer)
                } else if self.is_nan() {
                    serializer.serialize_none()
                } else {
                    Err(S::Error::custom(format_args!("{field} is {self}, which JSON can't represent")))
                }
            }

            fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                if !deserializer.is_human_readable() {
                    return Deserialize::deserialize(deserializer);
                }
                let value = Option::<Self>::deserialize(deserializer)?;
                let value = value.unwrap_or(Self::NAN);
                if value.is_infinite() {
                    return Err(D::Error::custom(concat!("the number is too large for ", stringify!($type))));
                }
                Ok(value)
            }
        })*
    };
}

float_fields!(f32, f64);

impl<T: Value, const N: usize> Field for [T; N] {
    fn serialize<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_tuple(N)?;
        for value in self {
            out.serialize_element(&Named { name: field, value })?;
        }
        out.end()
    }

    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(N, ArrayVisitor(PhantomData))
    }
}

struct ArrayVisitor<T, const N: usize>(PhantomData<T>);

impl<'de, T: Value, const N: usize> Visitor<'de> for ArrayVisitor<T, N> {
    type Value = [T; N];

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "an array of {N}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<[T; N], A::Error> {
        let mut array = core::array::from_fn(|_| T::initial());
        for (index, element) in array.iter_mut().enumerate() {
            let value = seq.next_element_seed(FieldSeed(PhantomData))?;
            *element = value.ok_or_else(|| A::Error::invalid_length(index, &self))?;
        }
        if seq.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::custom(format_args!(
                "found more than {N} elements, expected an array of {N}"
            )));
        }
        Ok(array)
    }
}

#[cfg(feature = "alloc")]
impl<T: Field> Field for Vec<T> {
    fn serialize<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeSeq as _;

        let mut out = serializer.serialize_seq(Some(self.len()))?;
        for value in self {
            out.serialize_element(&Named { name: field, value })?;
        }
        out.end()
    }

    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(SequenceVisitor(PhantomData))
    }
}

#[cfg(feature = "alloc")]
struct SequenceVisitor<T>(PhantomData<T>);

#[cfg(feature = "alloc")]
impl<'de, T: Field> Visitor<'de> for SequenceVisitor<T> {
    type Value = Vec<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<T>, A::Error> {
        // Doesn't trust the announced length: the vector grows with its elements.
        let mut sequence = Vec::new();
        while let Some(value) = seq.next_element_seed(FieldSeed(PhantomData))? {
            sequence.push(value);
        }
        Ok(sequence)
    }
}

impl<const N: usize> Field for Text<N> {
    fn serialize<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        let text = self.as_str().map_err(|error| S::Error::custom(format_args!("{field}: {error}")))?;
        serializer.serialize_str(text)
    }

    fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(TextVisitor(PhantomData))
    }
}

struct TextVisitor<T>(PhantomData<T>);

impl<const N: usize> Visitor<'_> for TextVisitor<Text<N>> {
    type Value = Text<N>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "a string of at most {N} bytes")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Text<N>, E> {
        text.parse().map_err(E::custom)
    }
}

/// Implements the serde traits for a message, from its fields and their indices.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_record {
    ($type:ident[$count:literal]; $($index:literal $field:ident)*) => {
        impl $crate::json::Fields for $type {
            type PerField = [(); $count];

            #[allow(unused_variables, clippy::inline_always, clippy::match_single_binding)]
            #[inline(always)]
            fn read_field<'de, S: $crate::json::Source<'de>>(&mut self, index: usize, source: &mut S) {
                match index {
                    $($index => source.read(&mut self.$field),)*
                    _ => {}
                }
            }
        }

        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(&self, serializer: S) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::json::serialize(self, serializer)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(deserializer: D) -> ::core::result::Result<Self, D::Error> {
                $crate::json::deserialize(deserializer)
            }
        }
    };
}

/// Implements the serde traits for a newtype over a number.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_number {
    ($type:ty) => {
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serialize::serialize(&self.0, serializer)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                ::core::result::Result::Ok(Self($crate::serde::Deserialize::deserialize(deserializer)?))
            }
        }
    };
}

/// Implements `Field` for a newtype over a number.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_field {
    ($type:ty) => {
        impl $crate::json::Field for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serialize::serialize(&self.0, serializer)
            }

            fn deserialize<'de, D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                $crate::serde::Deserialize::deserialize(deserializer)
            }
        }
    };
}
