//! Ids of rules about body schemas.

/// A value has the declared type. It may be `null` only if the page allows it.
pub(super) const TYPE: &str = "SHAPE-TYPE";
/// An object has all required fields.
pub(super) const REQUIRED: &str = "SHAPE-REQUIRED";
/// A closed object has no additional fields.
pub(super) const FURTHER: &str = "SHAPE-FURTHER";
/// A number is in its range.
pub(super) const RANGE: &str = "SHAPE-RANGE";
/// The length of a string, list or tuple is in its range.
pub(super) const LENGTH: &str = "SHAPE-LENGTH";
/// The elements of a list are unique if the page requires it.
pub(super) const UNIQUE: &str = "SHAPE-UNIQUE";
/// A string matches its pattern and its format.
pub(super) const PATTERN: &str = "SHAPE-PATTERN";
/// A value of a closed set is one of the listed values.
pub(super) const VALUE: &str = "SHAPE-VALUE";
