//! What generated types of JSON messages are made of: objects, tuples, sets and alternatives, as specification
//! pages define them.
//!
//! A type says what it is once, in a call of one of the macros, and gets from it how it is read and written.
//! Reading takes the fields of an object in any order and refuses missing and repeated ones; further fields are
//! passed over unless the page closes the object. A field that may be left out is not the same as one that may be
//! `null`: `null` is refused where the page doesn't name it. Integers are read where they stand without a fraction: `1.0`
//! is refused, which JSON Schema takes for the integer 1. Ranges, lengths and patterns are not looked at, so that
//! what is wrong with a message can be told by who reads it.
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

use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;
use core::fmt;

use serde::de::{DeserializeOwned, Error as _, IgnoredAny, MapAccess};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serializer};

/// Any JSON value.
pub use serde_json::Value as Json;

/// The field that holds the type of a message.
const TYPE: &str = "type";

/// Reads the value of the field `name`, which may stand in an object once.
pub fn read<'de, T: Deserialize<'de>, A: MapAccess<'de>>(
    field: &mut Option<T>,
    name: &'static str,
    map: &mut A,
) -> Result<(), A::Error> {
    if field.is_some() {
        return Err(A::Error::duplicate_field(name));
    }
    *field = Some(map.next_value().map_err(|error| inside(name, &error))?);
    Ok(())
}

/// What is wrong with a value, and in which field it stands.
fn inside<E: serde::de::Error>(name: &str, error: &E) -> E {
    E::custom(format!("{name}: {error}"))
}

/// Passes over the value of a field that the page doesn't name, or refuses it where there are no others.
pub fn read_further<'de, A: MapAccess<'de>>(
    name: &str,
    known: Option<&'static [&'static str]>,
    map: &mut A,
) -> Result<(), A::Error> {
    match known {
        Some(known) => Err(A::Error::unknown_field(name, known)),
        None => map.next_value::<IgnoredAny>().map(|_| ()),
    }
}

/// The name of a field as it is read.
#[derive(Debug)]
pub struct Key<'de>(pub Cow<'de, str>);

impl<'de> Deserialize<'de> for Key<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Key<'de>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the name of a field")
            }

            fn visit_borrowed_str<E>(self, name: &'de str) -> Result<Key<'de>, E> {
                Ok(Key(Cow::Borrowed(name)))
            }

            fn visit_str<E>(self, name: &str) -> Result<Key<'de>, E> {
                Ok(Key(Cow::Owned(String::from(name))))
            }

            fn visit_string<E>(self, name: String) -> Result<Key<'de>, E> {
                Ok(Key(Cow::Owned(name)))
            }
        }

        deserializer.deserialize_identifier(Visitor)
    }
}

// The macros name what they declare with two underscores: a page may have a type of any other name.

/// Takes a message apart: its type, and its other fields.
pub fn message_parts<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(String, Json), D::Error> {
    let mut value = Json::deserialize(deserializer)?;
    let Some(fields) = value.as_object_mut() else {
        return Err(D::Error::custom("a message is an object"));
    };
    match fields.shift_remove(TYPE) {
        Some(Json::String(name)) => Ok((name, value)),
        Some(_) => Err(D::Error::custom("the type of a message is a string")),
        None => Err(D::Error::missing_field(TYPE)),
    }
}

/// The message that [`message_parts`] took apart.
pub fn message_whole(name: String, mut value: Json) -> Json {
    if let Some(fields) = value.as_object_mut() {
        fields.shift_insert(0, String::from(TYPE), Json::String(name));
    }
    value
}

/// Reads a body from what [`message_parts`] gave.
pub fn read_body<T: DeserializeOwned, E: serde::de::Error>(name: &str, value: Json) -> Result<T, E> {
    T::deserialize(value).map_err(|error| E::custom(format!("{name}: {error}")))
}

/// An object that can write its fields beside others: a message has its type before those of its body.
pub trait Object {
    /// Writes the fields.
    fn write_fields<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error>;
}

/// Writes a body as a message.
pub fn write_message<T: Object, S: Serializer>(
    name: &str,
    body: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    map.serialize_entry(TYPE, name)?;
    body.write_fields(&mut map)?;
    map.end()
}

/// Makes a struct a JSON object: `json_object! { Mark open; name "name" required; height "height" optional; }`.
/// The fields that are `optional` are of the type `Option`, and are left out where they are `None`.
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

        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                let mut map = $crate::serde::Serializer::serialize_map(serializer, ::core::option::Option::None)?;
                $crate::json_type::Object::write_fields(self, &mut map)?;
                $crate::serde::ser::SerializeMap::end(map)
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                struct __Visitor;

                impl<'de> $crate::serde::de::Visitor<'de> for __Visitor {
                    type Value = $type;

                    fn expecting(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                        formatter.write_str(concat!("an object with the fields of ", stringify!($type)))
                    }

                    fn visit_map<__Access: $crate::serde::de::MapAccess<'de>>(
                        self,
                        mut map: __Access,
                    ) -> ::core::result::Result<$type, __Access::Error> {
                        $(let mut $field = ::core::option::Option::None;)*
                        while let ::core::option::Option::Some(key) =
                            map.next_key::<$crate::json_type::Key<'de>>()?
                        {
                            match &*key.0 {
                                $($name => $crate::json_type::read(&mut $field, $name, &mut map)?,)*
                                other => {
                                    let known: ::core::option::Option<&'static [&'static str]> =
                                        $crate::__json_known!($openness $($name)*);
                                    $crate::json_type::read_further(other, known, &mut map)?;
                                }
                            }
                        }
                        ::core::result::Result::Ok($type {
                            $($field: $crate::__json_take!($presence $name $field),)*
                        })
                    }
                }

                $crate::serde::Deserializer::deserialize_map(deserializer, __Visitor)
            }
        }
    };
}

/// Writes a field of an object.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_write {
    (required $map:ident $name:literal $value:expr) => {
        $crate::serde::ser::SerializeMap::serialize_entry($map, $name, &$value)?
    };
    (optional $map:ident $name:literal $value:expr) => {
        if let ::core::option::Option::Some(value) = &$value {
            $crate::serde::ser::SerializeMap::serialize_entry($map, $name, value)?;
        }
    };
}

/// What was read of a field of an object.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_take {
    (required $name:literal $field:ident) => {
        match $field {
            ::core::option::Option::Some(value) => value,
            ::core::option::Option::None => {
                return ::core::result::Result::Err($crate::serde::de::Error::missing_field($name));
            }
        }
    };
    (optional $name:literal $field:ident) => {
        $field
    };
}

/// The names of the fields of an object that has no others.
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

/// Makes a struct a JSON array with a meaning for each position: `json_tuple! { Mark; lat required; height nullable; }`.
/// All but what is `required` are of the type `Option`. What is `nullable` is `null` where it is `None`, what is
/// `optional` can be left out at the end, and what is `omissible` can be both.
#[macro_export]
macro_rules! json_tuple {
    ($type:ident; $($field:ident $presence:ident;)*) => {
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                // What can be left out is written up to the last that is there.
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
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                struct __Visitor;

                impl<'de> $crate::serde::de::Visitor<'de> for __Visitor {
                    type Value = $type;

                    fn expecting(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                        formatter.write_str(concat!("an array with the elements of ", stringify!($type)))
                    }

                    fn visit_seq<__Access: $crate::serde::de::SeqAccess<'de>>(
                        self,
                        mut list: __Access,
                    ) -> ::core::result::Result<$type, __Access::Error> {
                        let mut length = 0_usize;
                        $(
                            let $field = $crate::__json_next!($presence list length $field);
                            length += 1;
                        )*
                        if list.next_element::<$crate::serde::de::IgnoredAny>()?.is_some() {
                            return ::core::result::Result::Err($crate::serde::de::Error::invalid_length(
                                length + 1,
                                &self,
                            ));
                        }
                        ::core::result::Result::Ok($type { $($field),* })
                    }
                }

                $crate::serde::Deserializer::deserialize_seq(deserializer, __Visitor)
            }
        }
    };
}

/// Whether an element of a tuple has to be written.
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
            return ::core::result::Result::Err($crate::serde::ser::Error::custom(concat!(
                "`",
                stringify!($field),
                "` is left out, but elements after it are not"
            )));
        }
        $crate::serde::ser::SerializeSeq::serialize_element(&mut $list, &$self.$field)?;
    };
    ($presence:ident $list:ident $self:ident.$field:ident) => {
        $crate::serde::ser::SerializeSeq::serialize_element(&mut $list, &$self.$field)?;
    };
}

/// Reads an element of a tuple.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_next {
    (optional $list:ident $length:ident $field:ident) => {
        $list.next_element()?
    };
    (omissible $list:ident $length:ident $field:ident) => {
        $list.next_element::<::core::option::Option<_>>()?.flatten()
    };
    ($presence:ident $list:ident $length:ident $field:ident) => {
        match $list.next_element()? {
            ::core::option::Option::Some(value) => value,
            ::core::option::Option::None => {
                return ::core::result::Result::Err($crate::serde::de::Error::invalid_length(
                    $length,
                    &concat!("an array that has the element `", stringify!($field), "`"),
                ));
            }
        }
    };
}

/// Makes an enum a set of strings: `json_strings! { Phase open; Towed "towed"; }`. An open one has the variant
/// `Unnamed` for all other strings.
#[macro_export]
macro_rules! json_strings {
    ($type:ident open; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// The value as it stands in JSON.
            pub fn as_str(&self) -> &str {
                match self {
                    $(Self::$variant => $value,)*
                    Self::Unnamed(other) => other,
                }
            }

            /// Whether the definition names it.
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

            /// The value as it stands in JSON.
            pub const fn as_str(&self) -> &'static str {
                match self {
                    $(Self::$variant => $value,)*
                }
            }
        }

        $crate::__json_strings!($type |text| Self::ALL.iter().find(|known| known.as_str() == text).copied());
    };
}

/// What all sets of strings have.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_strings {
    ($type:ident |$text:ident| $read:expr) => {
        impl ::core::fmt::Display for $type {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                formatter.pad(self.as_str())
            }
        }

        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serializer::serialize_str(serializer, self.as_str())
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let found: $crate::alloc::borrow::Cow<'de, str> =
                    $crate::serde::Deserialize::deserialize(deserializer)?;
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
    };
}

/// Makes an enum a set of integers: `json_integers! { Fix closed; Value0 0; }`. An open one has the variant `Unnamed`
/// for all other integers.
#[macro_export]
macro_rules! json_integers {
    ($type:ident open; $($variant:ident $value:literal;)*) => {
        impl $type {
            /// The value as it stands in JSON.
            pub const fn value(self) -> i64 {
                match self {
                    $(Self::$variant => $value,)*
                    Self::Unnamed(other) => other,
                }
            }

            /// Whether the definition names it.
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

            /// The value as it stands in JSON.
            pub const fn value(self) -> i64 {
                match self {
                    $(Self::$variant => $value,)*
                }
            }
        }

        $crate::__json_integers!($type |value| Self::ALL.iter().copied().find(|known| known.value() == value));
    };
}

/// What all sets of integers have.
#[doc(hidden)]
#[macro_export]
macro_rules! __json_integers {
    ($type:ident |$value:ident| $read:expr) => {
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                $crate::serde::Serializer::serialize_i64(serializer, self.value())
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let $value: i64 = $crate::serde::Deserialize::deserialize(deserializer)?;
                let read: ::core::option::Option<Self> = $read;
                read.ok_or_else(|| {
                    $crate::serde::de::Error::invalid_value(
                        $crate::serde::de::Unexpected::Signed($value),
                        &concat!("a value of ", stringify!($type)),
                    )
                })
            }
        }
    };
}

/// Makes a newtype the JSON of what it holds: `json_named! { Instant value; }`. One over a string, which is `text`, is
/// made of any text, and gives it back.
#[macro_export]
macro_rules! json_named {
    ($type:ident value;) => {
        $crate::__json_number!($type);
    };
    ($type:ident text;) => {
        $crate::__json_number!($type);

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

/// Makes an enum an alternative of types: `json_either! { Place; Mark; String; }`, each variant of which holds one.
/// The first that reads a value has it.
#[macro_export]
macro_rules! json_either {
    ($type:ident; $($variant:ident;)*) => {
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
                serializer: S,
            ) -> ::core::result::Result<S::Ok, S::Error> {
                match self {
                    $(Self::$variant(value) => $crate::serde::Serialize::serialize(value, serializer),)*
                }
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let value: $crate::json_type::Json = $crate::serde::Deserialize::deserialize(deserializer)?;
                $(
                    if let ::core::result::Result::Ok(found) = $crate::serde::Deserialize::deserialize(&value) {
                        return ::core::result::Result::Ok(Self::$variant(found));
                    }
                )*
                ::core::result::Result::Err($crate::serde::de::Error::custom(concat!(
                    "none of the types that ",
                    stringify!($type),
                    " may be"
                )))
            }
        }
    };
}

/// Makes an enum the messages of a direction, told apart by their `type`:
/// `json_messages! { Request; GliderInf glider_inf "GLIDER-INF"; }`. Each variant holds a body, which is the type of the
/// same name in the module that is given; the variant `Other` holds the JSON of a message of any other type.
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
            /// The type of the message; empty where a message of another type was made without any.
            pub fn message_type(&self) -> &str {
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
                match self {
                    $(Self::$variant(body) => $crate::json_type::write_message($name, body, serializer),)*
                    Self::Other(other) => $crate::serde::Serialize::serialize(other, serializer),
                }
            }
        }

        impl<'de> $crate::serde::Deserialize<'de> for $type {
            fn deserialize<D: $crate::serde::Deserializer<'de>>(
                deserializer: D,
            ) -> ::core::result::Result<Self, D::Error> {
                let (name, body) = $crate::json_type::message_parts(deserializer)?;
                match name.as_str() {
                    $($name => $crate::json_type::read_body($name, body).map(Self::$variant),)*
                    _ => ::core::result::Result::Ok(Self::Other($crate::json_type::message_whole(name, body))),
                }
            }
        }
    };
}
