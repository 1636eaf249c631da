//! Building blocks for the generated types of JSON messages: objects, tuples, sets and alternatives, as defined on
//! specification pages.
//!
//! Each generated type calls one of the macros, which implement `Serialize` and `Deserialize`.
//!
//! Reading accepts the fields of an object in any order, and rejects missing and repeated fields. Unknown fields are
//! ignored unless the page forbids them. An optional field may be absent, but `null` is an error unless the page allows
//! it. Integers have no fraction: reading rejects `1.0`, although JSON Schema accepts it as the integer 1. Reading
//! doesn't check ranges, lengths or patterns, so a program can read an invalid message and report the violation.
//!
//! Sets, and named strings, numbers and booleans, can be read from any serde format. They can also be the keys of a
//! JSON object. All other types parse the whole value before they read it. Parsing requires a self-describing format,
//! such as JSON.
//!
//! NaN and infinity have no JSON form: writing them is an error that names the field.
//!
//! ```
//! use uavspec_runtime::json_object;
//!
//! #[derive(Debug, PartialEq)]
//! struct Mark {
//!     name: String,
//!     height: Option<f64>,
//! }
//!
//! json_object! {
//!     Mark open;
//!     name "name" required;
//!     height "height" optional;
//! }
//!
//! let mark: Mark = serde_json::from_str(r#"{"name": "A", "colour": "red"}"#)?;
//! assert_eq!(mark, Mark { name: "A".to_owned(), height: None });
//! # Ok::<(), serde_json::Error>(())
//! ```

use alloc::boxed::Box;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::any::TypeId;
use core::convert::Infallible;
use core::{fmt, ptr};

use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::map::Entry;
use serde_json::{Map, Number};

/// The reason why a value can't be read.
#[doc(hidden)]
pub use serde_json::Error;
/// Any JSON value.
pub use serde_json::Value as Json;

/// The field that contains the message type.
const TYPE: &str = "type";

/// The name in the object that represents a number, if the feature `arbitrary_precision` of `serde_json` is enabled. Only
/// `serde_json` can read this object.
const NUMBER: &str = "$serde_json::private::Number";

/// The Rust type of a JSON type: a type that a page defines, or the type of a field.
#[doc(hidden)]
pub trait JsonType: Sized {
    /// Writes the value. Error messages contain the name `field`.
    fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error>;

    /// Reads a value. A type without parts implements `parse` instead; any other type implements this method. By
    /// default, each method calls the other.
    fn read(json: &Json, _: &mut Choices) -> Result<Self, Error> {
        Self::parse(json)
    }

    /// Reads a value that is not a part of another value. The format must be self-describing, unless the type implements
    /// this method.
    fn parse<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Parsed(json) = Parsed::deserialize(deserializer)?;
        Self::read(&json, &mut Choices::default()).map_err(D::Error::custom)
    }
}

/// A JSON value whose objects have no repeated fields. `Json` would keep only the last value of a repeated field.
struct Parsed(Json);

impl<'de> Deserialize<'de> for Parsed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Parser).map(Self)
    }
}

struct Parser;

impl<'de> Visitor<'de> for Parser {
    type Value = Json;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_none<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Json, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::Number(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::Number(value.into()))
    }

    fn visit_i128<E: serde::de::Error>(self, value: i128) -> Result<Json, E> {
        let number = Number::from_i128(value).map(Json::Number);
        number.ok_or_else(|| E::custom(format_args!("the number {value} is out of range")))
    }

    fn visit_u128<E: serde::de::Error>(self, value: u128) -> Result<Json, E> {
        let number = Number::from_u128(value).map(Json::Number);
        number.ok_or_else(|| E::custom(format_args!("the number {value} is out of range")))
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Json, E> {
        let number = Number::from_f64(value).map(Json::Number);
        number.ok_or_else(|| E::custom(format_args!("found {value}, which JSON can't represent")))
    }

    fn visit_str<E>(self, text: &str) -> Result<Json, E> {
        Ok(Json::String(String::from(text)))
    }

    fn visit_string<E>(self, text: String) -> Result<Json, E> {
        Ok(Json::String(text))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Json, A::Error> {
        // Doesn't trust the announced length: the vector grows with its elements.
        let mut elements = Vec::new();
        while let Some(Parsed(element)) = list.next_element()? {
            elements.push(element);
        }
        Ok(Json::Array(elements))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Json, A::Error> {
        let mut fields = Map::new();
        while let Some(name) = map.next_key::<String>()? {
            match fields.entry(name) {
                Entry::Vacant(field) => {
                    let Parsed(value) = map.next_value()?;
                    field.insert(value);
                }
                Entry::Occupied(field) => {
                    return Err(A::Error::custom(format_args!("duplicate field `{}`", field.key())));
                }
            }
        }
        // `serde_json` represents numbers as strings. Without this check, each level of nested objects would rebuild
        // all inner levels.
        if fields.len() == 1 && matches!(fields.get(NUMBER), Some(Json::String(_))) {
            return Json::deserialize(Json::Object(fields)).map_err(A::Error::custom);
        }
        Ok(Json::Object(fields))
    }
}

/// The choices between alternatives made while reading. For each value and each type that it was read as, the map
/// contains the index of the first alternative that may accept the value.
///
/// If an alternative rejects a value, the next alternative reads the nested values again. Without these choices, the
/// time would double with each level of nesting.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct Choices(BTreeMap<(*const Json, TypeId), usize>);

/// Reads a value as one of several alternatives.
type Read<T> = fn(&Json, &mut Choices) -> Result<T, Error>;

/// Reads a value as the first of several alternatives that accepts it. The `name` of the type is for the error.
#[doc(hidden)]
pub fn read_either<T: 'static>(
    name: &str,
    json: &Json,
    choices: &mut Choices,
    alternatives: &[Read<T>],
) -> Result<T, Error> {
    // All values are parts of one parsed value, so each has a different address.
    let key = (ptr::from_ref(json), TypeId::of::<T>());
    let first = choices.0.get(&key).copied().unwrap_or_default();
    for (index, read) in alternatives.iter().enumerate().skip(first) {
        if let Ok(found) = read(json, choices) {
            choices.0.insert(key, index);
            return Ok(found);
        }
    }
    choices.0.insert(key, alternatives.len());
    Err(Error::custom(format_args!("the value matches no alternative of {name}")))
}

/// The fields of an object. Returns an error if the object allows only the `known` fields and has another one.
#[doc(hidden)]
pub fn fields<'j>(
    json: &'j Json,
    expected: &'static str,
    known: Option<&'static [&'static str]>,
) -> Result<&'j Map<String, Json>, Error> {
    let fields = object(json, expected)?;
    if let Some(known) = known
        && let Some(unknown) = fields.keys().find(|name| !known.contains(&name.as_str()))
    {
        return Err(Error::unknown_field(unknown, known));
    }
    Ok(fields)
}

/// Reads a field that must be present.
#[doc(hidden)]
pub fn required<T: JsonType>(
    fields: &Map<String, Json>,
    name: &'static str,
    choices: &mut Choices,
) -> Result<T, Error> {
    optional(fields, name, choices)?.ok_or_else(|| Error::missing_field(name))
}

/// Reads a field that may be absent.
#[doc(hidden)]
pub fn optional<T: JsonType>(
    fields: &Map<String, Json>,
    name: &'static str,
    choices: &mut Choices,
) -> Result<Option<T>, Error> {
    fields.get(name).map(|json| read_named(&name, json, choices)).transpose()
}

/// Reads a value. An error contains the `name` of the field, or the key or index of the element.
fn read_named<T: JsonType>(name: &dyn fmt::Display, json: &Json, choices: &mut Choices) -> Result<T, Error> {
    T::read(json, choices).map_err(|error| named(name, &error))
}

/// Adds a name to an error.
fn named(name: &dyn fmt::Display, error: &Error) -> Error {
    Error::custom(format_args!("{name}: {error}"))
}

/// The elements of a tuple.
#[doc(hidden)]
#[derive(Debug)]
pub struct Elements<'j> {
    all: &'j [Json],
    /// The elements that have not been read yet.
    left: &'j [Json],
}

impl<'j> Elements<'j> {
    /// The elements of an array. Returns an error if there are more than `max`.
    pub fn of(json: &'j Json, expected: &'static str, max: usize) -> Result<Self, Error> {
        let all = array(json, expected)?;
        if all.len() > max {
            return Err(Error::invalid_length(all.len(), &expected));
        }
        Ok(Self { all, left: all })
    }

    /// Reads the next element, which must be present.
    pub fn required<T: JsonType>(&mut self, name: &'static str, choices: &mut Choices) -> Result<T, Error> {
        self.optional(name, choices)?.ok_or_else(|| {
            let expected = format!("an array that has the element `{}`", element_name(name));
            Error::invalid_length(self.all.len(), &expected.as_str())
        })
    }

    /// Reads the next element, if there is one.
    pub fn optional<T: JsonType>(
        &mut self,
        name: &'static str,
        choices: &mut Choices,
    ) -> Result<Option<T>, Error> {
        let Some((json, left)) = self.left.split_first() else { return Ok(None) };
        self.left = left;
        read_named(&element_name(name), json, choices).map(Some)
    }
}

/// The name of an element of a tuple: its Rust identifier without the prefix of raw identifiers.
fn element_name(identifier: &'static str) -> &'static str {
    identifier.strip_prefix("r#").unwrap_or(identifier)
}

fn array<'j>(json: &'j Json, expected: &'static str) -> Result<&'j [Json], Error> {
    json.as_array().map(Vec::as_slice).ok_or_else(|| unexpected(json, expected))
}

fn object<'j>(json: &'j Json, expected: &'static str) -> Result<&'j Map<String, Json>, Error> {
    json.as_object().ok_or_else(|| unexpected(json, expected))
}

/// The error for a value of another type.
fn unexpected(json: &Json, expected: &'static str) -> Error {
    /// Accepts no value. The error names the type of the value.
    struct Refuse(&'static str);

    impl Visitor<'_> for Refuse {
        type Value = Infallible;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str(self.0)
        }
    }

    let Err(error) = json.deserialize_any(Refuse(expected));
    error
}

/// A value with the name of its field.
struct Named<'v, T> {
    name: &'static str,
    value: &'v T,
}

impl<T: JsonType> Serialize for Named<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.write(self.name, serializer)
    }
}

/// Writes a field of an object.
#[doc(hidden)]
pub fn write_field<T: JsonType, M: SerializeMap>(
    map: &mut M,
    name: &'static str,
    value: &T,
) -> Result<(), M::Error> {
    map.serialize_entry(name, &Named { name, value })
}

/// Writes an element of a tuple.
#[doc(hidden)]
pub fn write_element<T: JsonType, L: SerializeSeq>(
    list: &mut L,
    name: &'static str,
    value: &T,
) -> Result<(), L::Error> {
    list.serialize_element(&Named { name: element_name(name), value })
}

/// The error for an element of a tuple that is `None`, although a later element is not.
#[doc(hidden)]
pub fn skipped_element<E: serde::ser::Error>(name: &'static str) -> E {
    E::custom(format_args!("`{}` is None, but an element after it is not", element_name(name)))
}

/// Implements `JsonType` by calling serde's implementation for the type.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_plain {
    ($type:ty) => {
        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serialize::serialize(self, serializer)
            }

            fn parse<'de, D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                $crate::serde::Deserialize::deserialize(deserializer)
            }
        }
    };
}

__json_plain!(());
__json_plain!(bool);
__json_plain!(i64);
__json_plain!(String);

// Generated code needs only `i64`. Handwritten types may contain other integers.
__json_plain!(i8);
__json_plain!(i16);
__json_plain!(i32);
__json_plain!(u8);
__json_plain!(u16);
__json_plain!(u32);
__json_plain!(u64);

/// Implements `JsonType` for a float.
macro_rules! float {
    ($type:ident) => {
        impl JsonType for $type {
            fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
                if self.is_finite() {
                    self.serialize(serializer)
                } else {
                    let problem = format!("{field} is {self}, which JSON can't represent");
                    Err(serde::ser::Error::custom(problem))
                }
            }

            fn parse<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = Self::deserialize(deserializer)?;
                if value.is_finite() {
                    Ok(value)
                } else {
                    Err(D::Error::custom(format_args!("found {value}, expected a finite number")))
                }
            }
        }
    };
}

float!(f32);
float!(f64);

// Doesn't implement `parse`, because the implementation of `serde_json` accepts repeated fields.
impl JsonType for Json {
    fn write<S: Serializer>(&self, _: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        self.serialize(serializer)
    }

    fn read(json: &Json, _: &mut Choices) -> Result<Self, Error> {
        Ok(json.clone())
    }
}

impl<T: JsonType> JsonType for Option<T> {
    fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Some(value) => serializer.serialize_some(&Named { name: field, value }),
            None => serializer.serialize_none(),
        }
    }

    fn read(json: &Json, choices: &mut Choices) -> Result<Self, Error> {
        if json.is_null() { Ok(None) } else { T::read(json, choices).map(Some) }
    }
}

impl<T: JsonType> JsonType for Box<T> {
    fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        T::write(self, field, serializer)
    }

    fn read(json: &Json, choices: &mut Choices) -> Result<Self, Error> {
        T::read(json, choices).map(Self::new)
    }
}

impl<T: JsonType> JsonType for Vec<T> {
    fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        // With `collect_seq`, the compiler would copy more code for each type of elements.
        let mut list = serializer.serialize_seq(Some(self.len()))?;
        for value in self {
            list.serialize_element(&Named { name: field, value })?;
        }
        list.end()
    }

    fn read(json: &Json, choices: &mut Choices) -> Result<Self, Error> {
        let elements = array(json, "an array")?.iter().enumerate();
        elements.map(|(index, json)| read_named(&format_args!("[{index}]"), json, choices)).collect()
    }
}

impl<T: JsonType> JsonType for BTreeMap<String, T> {
    fn write<S: Serializer>(&self, field: &'static str, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.len()))?;
        for (key, value) in self {
            map.serialize_entry(key, &Named { name: field, value })?;
        }
        map.end()
    }

    fn read(json: &Json, choices: &mut Choices) -> Result<Self, Error> {
        let mut map = Self::new();
        for (key, json) in object(json, "an object")? {
            map.insert(key.clone(), read_named(key, json, choices)?);
        }
        Ok(map)
    }
}

/// Splits a message into its type and its other fields.
#[doc(hidden)]
pub fn split_message<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(String, Json), D::Error> {
    let Parsed(mut value) = Parsed::deserialize(deserializer)?;
    let Some(fields) = value.as_object_mut() else {
        return Err(D::Error::custom("expected a message object"));
    };
    match fields.shift_remove(TYPE) {
        Some(Json::String(name)) => Ok((name, value)),
        Some(_) => Err(D::Error::custom("expected a string as the message type")),
        None => Err(D::Error::missing_field(TYPE)),
    }
}

/// Joins the parts that [`split_message`] returned.
#[doc(hidden)]
pub fn join_message(name: String, mut value: Json) -> Json {
    if let Some(fields) = value.as_object_mut() {
        fields.shift_insert(0, String::from(TYPE), Json::String(name));
    }
    value
}

/// Reads a message body from the parts that [`split_message`] returned.
#[doc(hidden)]
pub fn read_body<T: JsonType>(name: &str, value: &Json, choices: &mut Choices) -> Result<T, Error> {
    read_named(&name, value, choices)
}

/// An object that can write its fields into a map that already has fields. In a message, the `type` field precedes the
/// fields of the body.
#[doc(hidden)]
pub trait Object {
    /// Writes the fields.
    fn write_fields<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error>;
}

/// Writes an object.
#[doc(hidden)]
pub fn write_object<T: Object, S: Serializer>(object: &T, serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    object.write_fields(&mut map)?;
    map.end()
}

/// Writes the type of a message. The fields of the body follow.
#[doc(hidden)]
pub fn start_message<S: Serializer>(name: &str, serializer: S) -> Result<S::SerializeMap, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    map.serialize_entry(TYPE, name)?;
    Ok(map)
}

// A page can define a type with any name, such as the name of a generic parameter. The macros therefore write `Self`
// instead of the name within functions, and declare no types.

/// Implements the serde traits for a `JsonType`.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_type {
    ($type:ident) => {
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::json_type::JsonType::write(self, stringify!($type), serializer)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                $crate::json_type::JsonType::parse(deserializer)
            }
        }
    };
}

/// Implements reading and writing of a struct as a JSON object:
/// `json_object! { Mark open; name "name" required; height "height" optional; }`.
///
/// An `optional` field has the type `Option`, and `None` is not written.
#[macro_export]
macro_rules! json_object {
    ($type:ident $openness:ident; $($field:ident $name:literal $presence:ident;)*) => {
        impl $crate::json_type::Object for $type {
            #[allow(unused_variables)] // some objects have no fields
            fn write_fields<M: $crate::serde::ser::SerializeMap>(
                &self,
                map: &mut M,
            ) -> ::core::result::Result<(), M::Error> {
                $($crate::__json_write!($presence map $name self.$field);)*
                ::core::result::Result::Ok(())
            }
        }

        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::json_type::write_object(self, serializer)
            }

            #[allow(unused_variables)] // some objects have no fields
            fn read(
                json: &$crate::json_type::Json,
                choices: &mut $crate::json_type::Choices,
            ) -> ::core::result::Result<Self, $crate::json_type::Error> {
                let fields = $crate::json_type::fields(
                    json,
                    concat!("an object with the fields of ", stringify!($type)),
                    $crate::__json_known!($openness $($name)*),
                )?;
                ::core::result::Result::Ok(Self {
                    $($field: $crate::json_type::$presence(fields, $name, choices)?,)*
                })
            }
        }

        $crate::__json_type!($type);
    };
}

/// Writes a field of an object.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_write {
    (required $map:ident $name:literal $value:expr) => {
        $crate::json_type::write_field($map, $name, &$value)?
    };
    (optional $map:ident $name:literal $value:expr) => {
        if let ::core::option::Option::Some(value) = &$value {
            $crate::json_type::write_field($map, $name, value)?;
        }
    };
}

/// The field names of a closed object, or `None` for an open object.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_known {
    (open $($name:literal)*) => {
        ::core::option::Option::None
    };
    (closed $($name:literal)*) => {
        ::core::option::Option::Some(&[$($name),*])
    };
}

/// Implements reading and writing of a struct as a JSON array in which each position has a meaning: `json_tuple! {
/// Mark; lat required; height nullable; }`.
///
/// Every element has the type `Option`, unless it is `required`. `None` in a `nullable` element is written as `null`.
/// An `optional` element can be absent at the end of the array. An `omissible` element can be `null` or absent.
#[macro_export]
macro_rules! json_tuple {
    ($type:ident; $($field:ident $presence:ident;)*) => {
        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                // Writes all elements up to the last element that is present.
                let is_needed = [$($crate::__json_is_needed!($presence self.$field)),*];
                let length = is_needed.iter().rposition(|is_needed| *is_needed).map_or(0, |last| last + 1);
                let mut list =
                    $crate::serde::Serializer::serialize_seq(serializer, ::core::option::Option::Some(length))?;
                let mut left = length;
                $(
                    if left > 0 {
                        left -= 1;
                        $crate::__json_element!($presence list self.$field);
                    }
                )*
                let _ = left;
                $crate::serde::ser::SerializeSeq::end(list)
            }

            fn read(
                json: &$crate::json_type::Json,
                choices: &mut $crate::json_type::Choices,
            ) -> ::core::result::Result<Self, $crate::json_type::Error> {
                let mut elements = $crate::json_type::Elements::of(
                    json,
                    concat!("an array with the elements of ", stringify!($type)),
                    <[&str]>::len(&[$(stringify!($field)),*]),
                )?;
                ::core::result::Result::Ok(Self {
                    $($field: $crate::__json_next!($presence elements $field choices),)*
                })
            }
        }

        $crate::__json_type!($type);
    };
}

/// True if an element of a tuple must be written.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_is_needed {
    (required $value:expr) => {
        true
    };
    (nullable $value:expr) => {
        true
    };
    ($optional:ident $value:expr) => {
        $value.is_some()
    };
}

/// Writes an element of a tuple.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_element {
    (optional $list:ident $self:ident.$field:ident) => {
        if $self.$field.is_none() {
            return ::core::result::Result::Err($crate::json_type::skipped_element(stringify!($field)));
        }
        $crate::json_type::write_element(&mut $list, stringify!($field), &$self.$field)?;
    };
    ($presence:ident $list:ident $self:ident.$field:ident) => {
        $crate::json_type::write_element(&mut $list, stringify!($field), &$self.$field)?;
    };
}

/// Reads an element of a tuple.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_next {
    (optional $elements:ident $field:ident $choices:ident) => {
        $elements.optional(stringify!($field), $choices)?
    };
    (omissible $elements:ident $field:ident $choices:ident) => {
        $elements.optional::<::core::option::Option<_>>(stringify!($field), $choices)?.flatten()
    };
    ($presence:ident $elements:ident $field:ident $choices:ident) => {
        $elements.required(stringify!($field), $choices)?
    };
}

/// Implements reading and writing of an enum as one of a set of strings:
/// `json_strings! { Phase open; Towed "towed"; }`.
///
/// An open enum has the variant `Unnamed` for all other strings.
#[macro_export]
macro_rules! json_strings {
    ($type:ident open; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// The value in JSON.
            pub fn as_str(&self) -> &str {
                match self {
                    $(Self::$variant => $value,)*
                    Self::Unnamed(other) => other,
                }
            }

            /// True if the definition names the value.
            pub fn is_known(&self) -> bool {
                !matches!(self, Self::Unnamed(_))
            }
        }

        impl ::core::convert::From<&str> for $type {
            fn from(text: &str) -> Self {
                match text {
                    $($value => Self::$variant,)*
                    other => Self::Unnamed($crate::alloc::string::String::from(other)),
                }
            }
        }

        $crate::__json_strings!($type |text| ::core::option::Option::Some(Self::from(text)));
    };
    ($type:ident closed; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// All values.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The value in JSON.
            pub const fn as_str(&self) -> &'static str {
                match self {
                    $(Self::$variant => $value,)*
                }
            }
        }

        $crate::__json_strings!($type |text| Self::ALL.iter().find(|known| known.as_str() == text).copied());
    };
}

/// The part of [`json_strings!`](crate::json_strings!) shared by open and closed enums.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_strings {
    ($type:ident |$text:ident| $read:expr) => {
        impl ::core::fmt::Display for $type {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                formatter.pad(self.as_str())
            }
        }

        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serializer::serialize_str(serializer, self.as_str())
            }

            fn parse<'de, D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let found: $crate::alloc::string::String = $crate::json_type::JsonType::parse(deserializer)?;
                let $text: &str = &found;
                let read: ::core::option::Option<Self> = $read;
                read.ok_or_else(|| {
                    $crate::serde::de::Error::invalid_value(
                        $crate::serde::de::Unexpected::Str($text),
                        &concat!("a value of ", stringify!($type)),
                    )
                })
            }
        }

        $crate::__json_type!($type);
    };
}

/// Implements reading and writing of an enum as one of a set of integers: `json_integers! { Fix closed; Value0 0; }`.
///
/// An open enum has the variant `Unnamed` for all other integers.
#[macro_export]
macro_rules! json_integers {
    ($type:ident open; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// The value in JSON.
            pub const fn value(self) -> i64 {
                match self {
                    $(Self::$variant => $value,)*
                    Self::Unnamed(other) => other,
                }
            }

            /// True if the definition names the value.
            pub const fn is_known(self) -> bool {
                !matches!(self, Self::Unnamed(_))
            }
        }

        impl ::core::convert::From<i64> for $type {
            fn from(value: i64) -> Self {
                match value {
                    $($value => Self::$variant,)*
                    other => Self::Unnamed(other),
                }
            }
        }

        $crate::__json_integers!($type |value| ::core::option::Option::Some(Self::from(value)));
    };
    ($type:ident closed; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// All values.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The value in JSON.
            pub const fn value(self) -> i64 {
                match self {
                    $(Self::$variant => $value,)*
                }
            }
        }

        $crate::__json_integers!($type |value| Self::ALL.iter().copied().find(|known| known.value() == value));
    };
}

/// The part of [`json_integers!`](crate::json_integers!) shared by open and closed enums.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_integers {
    ($type:ident |$value:ident| $read:expr) => {
        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                _: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serializer::serialize_i64(serializer, self.value())
            }

            fn parse<'de, D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let $value: i64 = $crate::json_type::JsonType::parse(deserializer)?;
                let read: ::core::option::Option<Self> = $read;
                read.ok_or_else(|| {
                    $crate::serde::de::Error::invalid_value(
                        $crate::serde::de::Unexpected::Signed($value),
                        &concat!("a value of ", stringify!($type)),
                    )
                })
            }
        }

        $crate::__json_type!($type);
    };
}

/// Implements reading and writing of a newtype as its inner value: `json_named! { Instant value; }`.
///
/// For a newtype over a string, use `text` instead of `value` to also implement conversions from and to strings.
#[macro_export]
macro_rules! json_named {
    ($type:ident value;) => {
        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                field: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::json_type::JsonType::write(&self.0, field, serializer)
            }

            fn read(
                json: &$crate::json_type::Json,
                choices: &mut $crate::json_type::Choices,
            ) -> ::core::result::Result<Self, $crate::json_type::Error> {
                $crate::json_type::JsonType::read(json, choices).map(Self)
            }

            fn parse<'de, D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                $crate::json_type::JsonType::parse(deserializer).map(Self)
            }
        }

        $crate::__json_type!($type);
    };
    ($type:ident text;) => {
        $crate::json_named! { $type value; }

        impl ::core::convert::From<&str> for $type {
            fn from(text: &str) -> Self {
                Self($crate::alloc::string::String::from(text))
            }
        }

        impl ::core::convert::From<$type> for $crate::alloc::string::String {
            fn from(value: $type) -> Self {
                value.0
            }
        }
    };
}

/// Implements reading and writing of an enum in which each variant contains a value of a different type: `json_either!
/// { Place; Mark; String; }`.
///
/// Reading tries the variants in order and uses the first variant that accepts the value.
#[macro_export]
macro_rules! json_either {
    ($type:ident; $($variant:ident;)*) => {
        impl $crate::json_type::JsonType for $type {
            fn write<S: $crate::serde::Serializer>(
                &self,
                field: &'static str,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                match self {
                    $(Self::$variant(value) => $crate::json_type::JsonType::write(value, field, serializer),)*
                }
            }

            fn read(
                json: &$crate::json_type::Json,
                choices: &mut $crate::json_type::Choices,
            ) -> ::core::result::Result<Self, $crate::json_type::Error> {
                $crate::json_type::read_either::<Self>(
                    stringify!($type),
                    json,
                    choices,
                    &[$(
                        |json, choices| $crate::json_type::JsonType::read(json, choices).map(Self::$variant)
                    ),*],
                )
            }
        }

        $crate::__json_type!($type);
    };
}

/// Implements reading and writing of an enum with one variant for each message type of a direction: `json_messages! {
/// Request; GliderInf glider_inf "GLIDER-INF"; }`.
///
/// The `type` field of a message selects the variant. Each variant contains a message body. The type of the body has
/// the same name as the enum and is in the given module. The `Other` variant contains a message of any other type, as
/// JSON.
#[macro_export]
macro_rules! json_messages {
    ($type:ident; $($variant:ident $module:ident $name:literal;)*) => {
        $(
            impl ::core::convert::From<$module::$type> for $type {
                fn from(body: $module::$type) -> Self {
                    Self::$variant(body)
                }
            }
        )*

        impl $type {
            /// The message type. Empty for an `Other` message without a type.
            pub fn message_type(&self) -> &::core::primitive::str {
                match self {
                    $(Self::$variant(_) => $name,)*
                    Self::Other(other) => other.get("type").and_then(|name| name.as_str()).unwrap_or_default(),
                }
            }
        }

        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                if let Self::Other(other) = self {
                    return $crate::serde::Serialize::serialize(other, serializer);
                }
                let mut map = $crate::json_type::start_message(self.message_type(), serializer)?;
                match self {
                    $(Self::$variant(body) => $crate::json_type::Object::write_fields(body, &mut map)?,)*
                    Self::Other(_) => {}
                }
                $crate::serde::ser::SerializeMap::end(map)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let (name, body) = $crate::json_type::split_message(deserializer)?;
                let choices = &mut $crate::json_type::Choices::default();
                let read: ::core::result::Result<Self, $crate::json_type::Error> = match name.as_str() {
                    $($name => $crate::json_type::read_body($name, &body, choices).map(Self::$variant),)*
                    _ => ::core::result::Result::Ok(Self::Other($crate::json_type::join_message(name, body))),
                };
                read.map_err($crate::serde::de::Error::custom)
            }
        }
    };
}
