//! The ids of rules on the shape of JSON.

/// A value has its type, which may be `null` only where the page says so.
pub(super) const TYPE: &str = "SHAPE-TYPE";
/// An object has all fields that it may not leave out.
pub(super) const REQUIRED: &str = "SHAPE-REQUIRED";
/// An object that is closed has no further fields.
pub(super) const FURTHER: &str = "SHAPE-FURTHER";
/// A number is in its range.
pub(super) const RANGE: &str = "SHAPE-RANGE";
/// A string, a list or a tuple is neither too short nor too long.
pub(super) const LENGTH: &str = "SHAPE-LENGTH";
/// No element stands twice in a list that has each once.
pub(super) const UNIQUE: &str = "SHAPE-UNIQUE";
/// A string has its pattern and its format.
pub(super) const PATTERN: &str = "SHAPE-PATTERN";
/// A value is one of those that are listed, where there are no others.
pub(super) const VALUE: &str = "SHAPE-VALUE";
