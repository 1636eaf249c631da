//! Ids of rules about body schemas.

/// A value must have the declared type. A value may be `null` only if the page allows `null`.
pub(super) const TYPE: &str = "SHAPE-TYPE";
/// An object must have all required fields.
pub(super) const REQUIRED: &str = "SHAPE-REQUIRED";
/// A closed object must not have additional fields.
pub(super) const FURTHER: &str = "SHAPE-FURTHER";
/// A number must be in its range.
pub(super) const RANGE: &str = "SHAPE-RANGE";
/// The length of a string, list or tuple must be in its range.
pub(super) const LENGTH: &str = "SHAPE-LENGTH";
/// The elements of a list must be unique if the page requires this.
pub(super) const UNIQUE: &str = "SHAPE-UNIQUE";
/// A string must match its pattern and its format.
pub(super) const PATTERN: &str = "SHAPE-PATTERN";
/// A value of a closed set must be one of the listed values.
pub(super) const VALUE: &str = "SHAPE-VALUE";
