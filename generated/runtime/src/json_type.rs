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

/// The field that contains the message type.
const TYPE: &str = "type";

/// Reads the value of the `name` field. A repeated field is an error.
pub fn read<'de, T: Deserialize<'de>, A: MapAccess<'de>>(
    field: &mut Option<T>,
    name: &'static str,
    map: &mut A,
) -> Result<(), A::Error> {
    if field.is_some() {
        return Err(A::Error::duplicate_field(name));
    }
    *field = Some(map.next_value().map_err(|error| in_field(name, &error))?);
    Ok(())
}

/// Adds the field name to the error message for a value.
fn in_field<E: serde::de::Error>(name: &str, error: &E) -> E {
    E::custom(format!("{name}: {error}"))
}

/// Skips the value of a field that the page doesn't define. Returns an error if the object allows only the `known`
/// fields.
pub fn read_unknown<'de, A: MapAccess<'de>>(
    name: &str,
    known: Option<&'static [&'static str]>,
    map: &mut A,
) -> Result<(), A::Error> {
    match known {
        Some(known) => Err(A::Error::unknown_field(name, known)),
        None => map.next_value::<IgnoredAny>().map(|_| ()),
    }
}

/// A field name, borrowed from the input if possible.
#[derive(Debug)]
pub struct Key<'de>(pub Cow<'de, str>);

impl<'de> Deserialize<'de> for Key<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Key<'de>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a field name")
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

// Names declared by the macros start with two underscores, because a page can define a type with any other name.

/// Splits a message into its type and its other fields.
pub fn split_message<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(String, Json), D::Error> {
    let mut value = Json::deserialize(deserializer)?;
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
pub fn join_message(name: String, mut value: Json) -> Json {
    if let Some(fields) = value.as_object_mut() {
        fields.shift_insert(0, String::from(TYPE), Json::String(name));
    }
    value
}

/// Reads a message body from the parts that [`split_message`] returned.
pub fn read_body<T: DeserializeOwned, E: serde::de::Error>(name: &str, value: Json) -> Result<T, E> {
    T::deserialize(value).map_err(|error| E::custom(format!("{name}: {error}")))
}

/// An object that can write its fields into a map that already has fields. In a message, the `type` field precedes the
/// fields of the body.
pub trait Object {
    /// Writes the fields.
    fn write_fields<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error>;
}

/// Writes a message from its type and its body.
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
                                    $crate::json_type::read_unknown(other, known, &mut map)?;
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

/// Takes the value that was read for a field of an object.
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
        impl $crate::serde::Serialize for $type {
            fn serialize<S: $crate::serde::Serializer>(
                &self,
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
            return ::core::result::Result::Err($crate::serde::ser::Error::custom(concat!(
                "`",
                stringify!($field),
                "` is None, but an element after it is not"
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

/// Implements reading and writing of a newtype as its inner value: `json_named! { Instant value; }`.
///
/// For a newtype over a string, use `text` instead of `value` to also implement conversions from and to strings.
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

/// Implements reading and writing of an enum in which each variant contains a value of a different type: `json_either!
/// { Place; Mark; String; }`.
///
/// Reading tries the variants in order and uses the first variant that accepts the value.
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
                    "the value matches no alternative of ",
                    stringify!($type)
                )))
            }
        }
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
                let (name, body) = $crate::json_type::split_message(deserializer)?;
                match name.as_str() {
                    $($name => $crate::json_type::read_body($name, body).map(Self::$variant),)*
                    _ => ::core::result::Result::Ok(Self::Other($crate::json_type::join_message(name, body))),
                }
            }
        }
    };
}
