//! The JSON values of fields: their types as text, and their bytes in memory.

use std::fmt;
use std::ops::Range;

use uavspec_dynamic::{Field, Leaf};
use uavspec_model::json::{Token, base64};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

/// Stores bytes in a part of the memory, and fills the rest of the part with zeros. The bytes must fit.
pub(super) fn keep_bytes(values: &mut [u8], part: Range<usize>, bytes: &[u8]) {
    if let Some(part) = values.get_mut(part)
        && let Some((used, rest)) = part.split_at_mut_checked(bytes.len())
    {
        used.copy_from_slice(bytes);
        rest.fill(0);
    }
}

/// The value of a token. `None` for numbers that are too large and for tokens that aren't JSON.
pub(super) fn leaf_of<'t>(token: &'t Token<'_>) -> Option<Leaf<'t>> {
    Some(match token {
        Token::Null => Leaf::Null,
        Token::Bool(value) => Leaf::Bool(*value),
        Token::Int(value) => Leaf::Int(*value),
        Token::Float(value, _) => Leaf::Float(*value),
        Token::Text(text) => Leaf::Text(text),
        Token::Huge(_) | Token::NotJson(_) => return None,
    })
}

/// True if the field is the timestamp of a message. The timestamp's definition has no restriction, so the field needs no
/// check.
pub(super) fn is_timestamp(field: &Field) -> bool {
    *field.name == *"timestamp"
        && field.element == Element::Scalar(Scalar::UInt64)
        && field.shape == Shape::Single
        && field.restriction.is_none()
}

/// The decoded bytes of an array that rosbridge wrote as base64.
///
/// The base64 of an array is longer than any text that fits into the array, so there is no ambiguity.
pub(super) fn as_base64(field: &Field, text: &str, is_rosbridge: bool, is_element: bool) -> Option<Vec<u8>> {
    let is_bytes = match field.element {
        Element::Text(room) => text.len() > room as usize,
        element => is_byte(element) && field.shape != Shape::Single && !is_element,
    };
    if is_rosbridge && is_bytes { base64::decode(text) } else { None }
}

/// True if rosbridge writes an array with these elements as base64.
pub fn is_byte(element: Element) -> bool {
    matches!(element, Element::Scalar(Scalar::UInt8 | Scalar::Byte | Scalar::Char))
}

/// Stores a value or an element at its offset in memory, if `values` isn't empty.
pub(super) fn keep(field: &Field, values: &mut [u8], at: usize, leaf: Leaf<'_>) {
    match (field.element, leaf) {
        _ if values.is_empty() => {}
        (Element::Text(room), Leaf::Text(text)) => {
            keep_bytes(values, at..at + room as usize, text.as_bytes());
        }
        (Element::Scalar(scalar), leaf) => {
            keep_bytes(values, at..at + scalar.size(), &leaf.bytes(scalar)[..scalar.size()]);
        }
        _ => {}
    }
}

/// The JSON type of a field, as text.
pub(super) struct Expected<'p> {
    pub(super) field: &'p Field,
    pub(super) is_element: bool,
}

impl fmt::Display for Expected<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.field.shape {
            Shape::Array(length) if !self.is_element => return write!(formatter, "an array of {length}"),
            Shape::Bounded(bound) if !self.is_element => {
                return write!(formatter, "an array of at most {bound}");
            }
            Shape::Sequence if !self.is_element => return formatter.write_str("an array"),
            _ => {}
        }
        match self.field.element {
            Element::Scalar(scalar) => match scalar.integer_bounds() {
                Some((low, high)) => write!(formatter, "an integer from {low} to {high}"),
                None if scalar.is_float() => formatter.write_str("a number, or null for NaN"),
                None => formatter.write_str("true or false"),
            },
            Element::Text(_) | Element::String { .. } => formatter.write_str("a string"),
            Element::Message(_) => formatter.write_str("an object"),
        }
    }
}
