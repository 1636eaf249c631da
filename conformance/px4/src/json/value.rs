//! The checks of JSON values against the types of their fields.

use std::fmt;
use std::ops::Range;

use uavspec_model::json::whole;
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::Shape;

use crate::values::{Element, FieldPlan, Violation, check_text};

/// A scalar value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaf<'t> {
    Null,
    Bool(bool),
    Int(i128),
    Float(f64),
    Text(&'t str),
}

impl Leaf<'_> {
    /// The little-endian bytes of the value in memory. The value must fit into this type.
    pub(super) fn bytes(self, scalar: Scalar) -> [u8; 8] {
        let float = |value: f64| match scalar {
            #[allow(clippy::cast_possible_truncation)] // rounded like any float32
            Scalar::Float32 => u64::from((value as f32).to_bits()),
            _ => value.to_bits(),
        };
        let bits = match self {
            Self::Null => float(f64::NAN),
            Self::Bool(value) => value.into(),
            #[allow(clippy::cast_precision_loss)] // rounded like any float
            Self::Int(value) if scalar.is_float() => float(value as f64),
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // two's complement
            Self::Int(value) => value as u64,
            Self::Float(value) if scalar.is_float() => float(value),
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // two's complement
            Self::Float(value) => whole(value).unwrap_or_default() as u64,
            Self::Text(_) => 0,
        };
        bits.to_le_bytes()
    }

    /// The value of an integer in any notation: JSON Schema accepts `5.0` as an integer.
    pub(super) fn integer(self) -> Option<i128> {
        match self {
            Self::Int(value) => Some(value),
            Self::Float(value) => whole(value),
            _ => None,
        }
    }
}

/// Stores bytes in a part of the memory, and fills the rest of the part with zeros. The bytes must fit.
pub(super) fn keep_bytes(values: &mut [u8], part: Range<usize>, bytes: &[u8]) {
    if let Some(part) = values.get_mut(part)
        && let Some((used, rest)) = part.split_at_mut_checked(bytes.len())
    {
        used.copy_from_slice(bytes);
        rest.fill(0);
    }
}

impl FieldPlan {
    /// Checks a value: the field itself, or one of its elements.
    pub(super) fn check(&self, leaf: Leaf<'_>) -> Result<(), Violation<'_>> {
        match (self.element, leaf) {
            (Element::Scalar(Scalar::Bool), Leaf::Bool(_)) => Ok(()),
            (Element::Scalar(scalar @ (Scalar::Float32 | Scalar::Float64)), leaf) => {
                self.constraint().check_number(float(scalar, leaf)?)
            }
            (Element::Scalar(scalar), leaf) => match (scalar.integer_bounds(), leaf.integer()) {
                (Some((low, high)), Some(value)) if (low..=high).contains(&value) => {
                    self.constraint().check_number(Number::Int(value))
                }
                _ => Err(Violation::Type),
            },
            (Element::Text(room), Leaf::Text(text)) => {
                if let Some(at) = memchr::memchr(0, text.as_bytes()) {
                    return Err(Violation::Nul(at));
                }
                at_most(text.len(), room, "bytes")
            }
            (Element::String { bound, .. }, Leaf::Text(text)) => match bound {
                // A string never has more characters than bytes.
                Some(bound) if text.len() > bound as usize => {
                    at_most(text.chars().count(), bound, "characters")
                }
                _ => Ok(()),
            },
            _ => Err(Violation::Type),
        }
    }

    /// Checks the number of elements of an array or a sequence.
    pub(super) fn check_length(&self, found: usize) -> Result<(), Violation<'_>> {
        let is_right = match self.shape {
            Shape::Single | Shape::Sequence => true,
            Shape::Array(length) => found == length as usize,
            Shape::Bounded(bound) => found <= bound as usize,
        };
        if is_right { Ok(()) } else { Err(Violation::Length { found, unit: "elements", shape: self.shape }) }
    }

    /// Checks the bytes of a text array.
    pub(super) fn check_text(&self, bytes: &[u8]) -> Result<(), Violation<'_>> {
        if let Element::Text(room) = self.element
            && bytes.len() != room as usize
        {
            return Err(Violation::Length { found: bytes.len(), unit: "bytes", shape: Shape::Array(room) });
        }
        check_text(bytes)
    }

    /// The expected JSON type of a value or element, as text.
    pub(super) fn expected(&self, is_element: bool) -> Expected<'_> {
        Expected { field: self, is_element }
    }
}

/// The value of a float. The value is rounded first, since ranges and special values apply to the rounded value.
fn float<'p>(scalar: Scalar, leaf: Leaf<'_>) -> Result<Number, Violation<'p>> {
    let value = match leaf {
        Leaf::Null => f64::NAN,
        #[allow(clippy::cast_precision_loss)] // rounded like any float
        Leaf::Int(value) => value as f64,
        Leaf::Float(value) => value,
        Leaf::Bool(_) | Leaf::Text(_) => return Err(Violation::Type),
    };
    #[allow(clippy::cast_possible_truncation)] // rounded like any float32
    let value = if scalar == Scalar::Float32 { f64::from(value as f32) } else { value };
    if value.is_infinite() { Err(Violation::TooLarge(scalar)) } else { Ok(Number::Float(value)) }
}

fn at_most<'p>(found: usize, bound: u32, unit: &'static str) -> Result<(), Violation<'p>> {
    let is_over = found > bound as usize;
    if is_over { Err(Violation::Length { found, unit, shape: Shape::Bounded(bound) }) } else { Ok(()) }
}

/// The JSON type of a field, as text.
pub(super) struct Expected<'p> {
    field: &'p FieldPlan,
    is_element: bool,
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
