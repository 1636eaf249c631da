//! Empty stand-ins for the traits and macros of disabled features.

/// A field value with a JSON form. Without the `serde` feature, every type implements this trait.
#[cfg(not(feature = "serde"))]
pub trait JsonField {}

#[cfg(not(feature = "serde"))]
impl<T> JsonField for T {}

/// A message with a JSON Schema. Without the `schemars` feature, every type implements this trait.
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

#[cfg(not(feature = "json"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __json_plain {
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
/// Implements `defmt::Format` for a message if the `defmt` feature is enabled.
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

/// Expands to the given code if the `json` feature is enabled, and to nothing otherwise.
#[cfg(not(feature = "json"))]
#[macro_export]
macro_rules! with_json {
    ($($code:tt)*) => {};
}

#[cfg(not(feature = "views"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __view_items {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "views"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __view {
    ($($tokens:tt)*) => {};
}

#[cfg(not(feature = "views"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __view_number {
    ($($tokens:tt)*) => {};
}

/// Expands to the given code if the `views` feature is enabled, and to nothing otherwise.
#[cfg(not(feature = "views"))]
#[macro_export]
macro_rules! with_views {
    ($($code:tt)*) => {};
}
