//! What generated code calls for features that are off: nothing.

/// A value as JSON; nothing is asked of it without the feature `serde`.
#[cfg(not(feature = "serde"))]
pub trait JsonField {}

#[cfg(not(feature = "serde"))]
impl<T> JsonField for T {}

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
