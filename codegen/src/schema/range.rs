//! Bounds and special values.

use crate::value::Value;

/// Inclusive bounds; an absent one is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Least value.
    pub low: Option<Value>,
    /// Greatest value.
    pub high: Option<Value>,
}

/// A value with a meaning of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Special {
    /// The value; none where it is an empty string or array.
    pub value: Option<Value>,
    /// When it applies, in words; may be empty.
    pub text: String,
}
