//! Single values: the one place that says what is wrong with them.

use std::fmt;

use uavspec_codegen::schema::{Restriction, Shape};
use uavspec_runtime::{Number, Rule, Scalar};

use super::plan::{Element, FieldPlan};
use crate::model::{self, Detail};
use crate::px4::ValueRules;

/// A value that holds no others.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leaf<'t> {
    Null,
    Bool(bool),
    Int(i128),
    Float(f64),
    Text(&'t str),
}

impl Leaf<'_> {
    /// What it is in memory, little-endian, as a value of a type that it fits into.
    pub(super) fn bytes(self, scalar: Scalar) -> [u8; 8] {
        let float = |value: f64| match scalar {
            #[allow(clippy::cast_possible_truncation)] // rounding is what a float32 does
            Scalar::Float32 => u64::from((value as f32).to_bits()),
            _ => value.to_bits(),
        };
        let bits = match self {
            Self::Null => float(f64::NAN),
            Self::Bool(value) => value.into(),
            #[allow(clippy::cast_precision_loss)] // what a float makes of an integer
            Self::Int(value) if scalar.is_float() => float(value as f64),
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // two's complement
            Self::Int(value) => value as u64,
            Self::Float(value) => float(value),
            Self::Text(_) => 0,
        };
        bits.to_le_bytes()
    }
}

/// What is wrong with a value.
#[derive(Debug)]
pub(super) enum Breach<'p> {
    /// It has another JSON type than its field, or is out of the range of an integer type.
    Type,
    /// It is finite, and infinite in the type of its field.
    TooLarge(Scalar),
    /// A rule on numbers.
    Number(Rule, Number, &'p Restriction),
    /// An array, a sequence or a string has too many or too few of what it is made of.
    Length { found: usize, of: &'static str, shape: Shape },
    /// A text has a NUL, which would end it.
    Nul(usize),
    /// Bytes that stand for text aren't UTF-8.
    NotUtf8(usize),
}

impl FieldPlan {
    /// Judges a value that the field, or an element of it, holds.
    pub(super) fn judge(&self, leaf: Leaf<'_>) -> Result<(), Breach<'_>> {
        match (self.element, leaf) {
            (Element::Scalar(Scalar::Bool), Leaf::Bool(_)) => Ok(()),
            (Element::Scalar(scalar @ (Scalar::Float32 | Scalar::Float64)), leaf) => {
                self.number(float(scalar, leaf)?)
            }
            (Element::Scalar(scalar), Leaf::Int(value)) => match scalar.integer_bounds() {
                Some((low, high)) if (low..=high).contains(&value) => self.number(Number::Int(value)),
                _ => Err(Breach::Type),
            },
            (Element::Text(room), Leaf::Text(text)) => {
                if let Some(at) = memchr::memchr(0, text.as_bytes()) {
                    return Err(Breach::Nul(at));
                }
                at_most(text.len(), room, "bytes")
            }
            (Element::String { bound }, Leaf::Text(text)) => match bound {
                // No string has more characters than bytes.
                Some(bound) if text.len() > bound as usize => {
                    at_most(text.chars().count(), bound, "characters")
                }
                _ => Ok(()),
            },
            _ => Err(Breach::Type),
        }
    }

    /// Judges how many elements an array or a sequence has.
    pub(super) fn judge_length(&self, found: usize) -> Result<(), Breach<'_>> {
        let is_right = match self.shape {
            Shape::Single | Shape::Sequence => true,
            Shape::Array(length) => found == length as usize,
            Shape::Bounded(bound) => found <= bound as usize,
        };
        if is_right { Ok(()) } else { Err(Breach::Length { found, of: "elements", shape: self.shape }) }
    }

    /// Judges text that is written as the bytes of its array.
    pub(super) fn judge_text(&self, bytes: &[u8]) -> Result<(), Breach<'_>> {
        if let Element::Text(room) = self.element
            && bytes.len() != room as usize
        {
            return Err(Breach::Length { found: bytes.len(), of: "bytes", shape: Shape::Array(room) });
        }
        let end = memchr::memchr(0, bytes).unwrap_or(bytes.len());
        std::str::from_utf8(&bytes[..end]).map_err(|error| Breach::NotUtf8(error.valid_up_to()))?;
        Ok(())
    }

    fn number(&self, found: Number) -> Result<(), Breach<'_>> {
        let Some(restriction) = &self.restriction else { return Ok(()) };
        match restriction.constraint().broken_by(found) {
            None => Ok(()),
            Some(rule) => Err(Breach::Number(rule, found, restriction)),
        }
    }

    /// What a value of it, or of an element, is in JSON.
    pub(super) fn expected(&self, is_element: bool) -> Expected<'_> {
        Expected { field: self, is_element }
    }
}

/// What a float makes of a value. Ranges and special values are those of the type, so it is rounded first.
fn float<'p>(scalar: Scalar, leaf: Leaf<'_>) -> Result<Number, Breach<'p>> {
    let value = match leaf {
        Leaf::Null => f64::NAN,
        #[allow(clippy::cast_precision_loss)] // what a float makes of an integer
        Leaf::Int(value) => value as f64,
        Leaf::Float(value) => value,
        Leaf::Bool(_) | Leaf::Text(_) => return Err(Breach::Type),
    };
    #[allow(clippy::cast_possible_truncation)] // rounding is what a float32 does
    let value = if scalar == Scalar::Float32 { f64::from(value as f32) } else { value };
    if value.is_infinite() { Err(Breach::TooLarge(scalar)) } else { Ok(Number::Float(value)) }
}

fn at_most<'p>(found: usize, bound: u32, of: &'static str) -> Result<(), Breach<'p>> {
    let is_over = found > bound as usize;
    if is_over { Err(Breach::Length { found, of, shape: Shape::Bounded(bound) }) } else { Ok(()) }
}

impl Breach<'_> {
    /// The rule that it violates.
    pub(super) fn rule(&self, rules: &ValueRules) -> &'static model::Rule {
        match self {
            Self::Type | Self::TooLarge(_) => rules.json_type,
            Self::Number(rule, ..) => rules.on(*rule),
            Self::Length { .. } => rules.length,
            Self::Nul(_) | Self::NotUtf8(_) => rules.text,
        }
    }

    /// Whether the value is the matter, and not the way in which it is written: then only what is in use counts.
    pub(super) fn is_of_value(&self) -> bool {
        matches!(self, Self::Number(..) | Self::Nul(_) | Self::NotUtf8(_))
    }

    /// What is said of it: what should be, and `found`, as it is written.
    pub(super) fn detail(&self, expected: &Expected<'_>, found: &str) -> Detail {
        match self {
            Self::Type => Detail::differs(expected, found),
            Self::TooLarge(scalar) => {
                let name = scalar.name();
                Detail::new(format!("expected {expected}, found {found}, which is too large for {name}"))
                    .expected(expected.to_string())
                    .actual(found)
            }
            Self::Number(rule, number, restriction) => Detail::of_number(*rule, *number, restriction),
            Self::Length { found, of, shape } => {
                let expected = match shape {
                    Shape::Array(length) => format!("{length} {of}"),
                    Shape::Bounded(bound) => format!("at most {bound} {of}"),
                    Shape::Single | Shape::Sequence => of.to_string(),
                };
                Detail::differs(expected, found)
            }
            Self::Nul(at) => Detail::new(format!("a NUL at its byte {at}, which ends a text")),
            Self::NotUtf8(at) => Detail::new(format!("no UTF-8 from its byte {at} on")).expected("UTF-8"),
        }
    }
}

/// The JSON type of a field, in words.
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
