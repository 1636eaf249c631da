//! Typed values of constants, defaults and bounds.
//!
//! ```
//! use uavspec_schema::value::Value;
//!
//! assert_eq!(Value::Float(0.5).to_string(), "0.5");
//! assert_eq!(Value::Int(3).as_f64(), Some(3.0));
//! ```

use std::fmt::{self, Write as _};

use uavspec_runtime::Number;

/// A value in a definition.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A `bool`.
    Bool(bool),
    /// An integer of any type, including `byte` and `char`.
    Int(i128),
    /// A float; may be NaN or infinite.
    Float(f64),
    /// A string.
    Text(String),
    /// An array.
    List(Vec<Value>),
}

impl Value {
    /// True for NaN.
    pub(crate) fn is_nan(&self) -> bool {
        matches!(self, Self::Float(value) if value.is_nan())
    }

    /// The value as a float, if it is a number.
    pub fn as_f64(&self) -> Option<f64> {
        self.number().map(Number::as_f64)
    }

    /// The value as an integer or float, if it is a number.
    pub fn number(&self) -> Option<Number> {
        match self {
            Self::Int(value) => Some(Number::Int(*value)),
            Self::Float(value) => Some(Number::Float(*value)),
            Self::Bool(_) | Self::Text(_) | Self::List(_) => None,
        }
    }

    /// The value as an integer, if it is an integer.
    pub fn as_int(&self) -> Option<i128> {
        match self {
            Self::Int(value) => Some(*value),
            Self::Bool(_) | Self::Float(_) | Self::Text(_) | Self::List(_) => None,
        }
    }
}

/// Formats the value as in a `.msg` file.
impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(formatter, "{value}"),
            Self::Int(value) => write!(formatter, "{value}"),
            Self::Float(value) if value.is_nan() => formatter.write_str("NaN"),
            Self::Float(value) => write!(formatter, "{value}"),
            Self::Text(value) => write_quoted(value, formatter),
            Self::List(values) => {
                formatter.write_str("[")?;
                for (index, value) in values.iter().enumerate() {
                    let separator = if index == 0 { "" } else { ", " };
                    write!(formatter, "{separator}{value}")?;
                }
                formatter.write_str("]")
            }
        }
    }
}

/// Writes `text` as a string literal, with the escapes that [`crate::msg::literal`] supports.
fn write_quoted(text: &str, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
    formatter.write_char('"')?;
    for character in text.chars() {
        match character {
            '"' => formatter.write_str("\\\"")?,
            '\\' => formatter.write_str("\\\\")?,
            '\n' => formatter.write_str("\\n")?,
            '\t' => formatter.write_str("\\t")?,
            '\r' => formatter.write_str("\\r")?,
            '\0' => formatter.write_str("\\0")?,
            _ => formatter.write_char(character)?,
        }
    }
    formatter.write_char('"')
}
