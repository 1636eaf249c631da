//! What generated code calls for features that are off: nothing.

/// A value as JSON; nothing is asked of it without the feature `serde`.
#[cfg(not(feature = "serde"))]
pub trait JsonField {}

#[cfg(not(feature = "serde"))]
impl<T> JsonField for T {}

/// A message with a JSON Schema; nothing is asked of it without the feature `schemars`.
#[cfg(not(feature = "schemars"))]
pub trait SchemaRecord {}

#[cfg(not(feature = "schemars"))]
impl<T> SchemaRecord for T {}

#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __json_record {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __json_field {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __json_number {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "proptest"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __arbitrary_record {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "proptest"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __arbitrary_number {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "schemars"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_record {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "schemars"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __schema_number {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "defmt"))]
/// Gives a message its `defmt::Format`; nothing without the feature `defmt`.
#[macro_export]
macro_rules! format_record {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __format_enum {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __format_flags {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __format_error_code {
    ($($tokens:tt)*) => {};
}

/// Takes generated code out, which with the feature `json` it leaves in.
#[cfg(not(feature = "json"))]
#[macro_export]
macro_rules! with_json {
    ($($code:tt)*) => {};
}
