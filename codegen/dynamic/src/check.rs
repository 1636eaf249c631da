//! Checks of single values against the constraints of their fields, in memory and in JSON.
//!
//! An encoding only determines how a value is read. Messages decoded from CDR are checked in memory.

use uavspec_runtime::{ConstraintKind, Number, Scalar};
use uavspec_schema::{Element, Restriction, Shape};

use super::bytes::{number_bytes, until_nul};
use super::plan::Field;
use super::text::Bounds;
use super::view::scalar_value;

/// A violation of a constraint by a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Violation<'t> {
    /// A bool whose byte is neither 0 nor 1.
    Bool(u8),
    /// A JSON value with the wrong type, or out of the range of an integer type.
    Type,
    /// A finite JSON number that becomes infinite in the type of its field.
    TooLarge(Scalar),
    /// A number that violates a constraint of its restriction.
    Number(ConstraintKind, Number, &'t Restriction),
    /// An array, sequence, text or string with the wrong length.
    Length {
        /// The length.
        found: usize,
        /// The unit of the length.
        unit: &'static str,
        /// The expected length.
        shape: Shape,
    },
    /// A NUL within a JSON string, at this byte. The NUL would terminate the text.
    Nul(usize),
    /// Text with invalid UTF-8 at this byte.
    NotUtf8(usize),
    /// A `wstring` with an unpaired surrogate at this code unit.
    NotUtf16(usize),
}

/// A scalar value in JSON.
#[derive(Clone, Copy, Debug)]
pub enum Leaf<'t> {
    /// `null`, which represents NaN.
    Null,
    /// `true` or `false`.
    Bool(bool),
    /// A number without fraction and exponent.
    Int(i128),
    /// Any other number.
    Float(f64),
    /// A string.
    Text(&'t str),
}

/// The type of a value, with the constraints on it.
#[derive(Clone, Copy, Debug)]
pub struct ValueType<'t> {
    /// The type.
    pub element: Element,
    /// The number of elements in the value's field.
    pub shape: Shape,
    /// The constraints on a number.
    pub restriction: Option<&'t Restriction>,
}

impl<'t> ValueType<'t> {
    /// Checks the little-endian bytes of a value in memory, or of the text of a string.
    pub fn check_bytes(self, bytes: &[u8]) -> Result<(), Violation<'t>> {
        match self.element {
            Element::Scalar(Scalar::Bool) => match bytes.first() {
                Some(byte @ 2..) => Err(Violation::Bool(*byte)),
                _ => Ok(()),
            },
            Element::Scalar(scalar) => number(scalar, bytes).map_or(Ok(()), |found| self.check_number(found)),
            Element::Text(_) => check_text(bytes),
            Element::String { wide, bound } => check_string(bytes, Bounds { is_wide: wide, bound }),
            Element::Message(_) => Ok(()),
        }
    }

    /// Checks a number.
    pub fn check_number(self, found: Number) -> Result<(), Violation<'t>> {
        let Some(restriction) = self.restriction else { return Ok(()) };
        match restriction.constraint().violated_by(found) {
            None => Ok(()),
            Some(kind) => Err(Violation::Number(kind, found, restriction)),
        }
    }

    /// Checks a JSON value: the field itself, or one of its elements.
    pub fn check_leaf(self, leaf: Leaf<'_>) -> Result<(), Violation<'t>> {
        match (self.element, leaf) {
            (Element::Scalar(Scalar::Bool), Leaf::Bool(_)) => Ok(()),
            (Element::Scalar(scalar @ (Scalar::Float32 | Scalar::Float64)), leaf) => {
                self.check_number(float(scalar, leaf)?)
            }
            (Element::Scalar(scalar), leaf) => match (scalar.integer_bounds(), leaf.integer()) {
                (Some((low, high)), Some(value)) if (low..=high).contains(&value) => {
                    self.check_number(Number::Int(value))
                }
                _ => Err(Violation::Type),
            },
            (Element::Text(room), Leaf::Text(text)) => {
                if let Some(at) = text.bytes().position(|byte| byte == 0) {
                    return Err(Violation::Nul(at));
                }
                let (found, shape) = (text.len(), Shape::Bounded(room));
                if found > room as usize {
                    Err(Violation::Length { found, unit: "bytes", shape })
                } else {
                    Ok(())
                }
            }
            (Element::String { wide, bound }, Leaf::Text(text)) => {
                check_characters(text.as_bytes(), Bounds { is_wide: wide, bound })
            }
            _ => Err(Violation::Type),
        }
    }

    /// Checks the number of elements of an array or a sequence.
    pub fn check_length(self, found: usize) -> Result<(), Violation<'t>> {
        let is_right = match self.shape {
            Shape::Single | Shape::Sequence => true,
            Shape::Array(length) => found == length as usize,
            Shape::Bounded(bound) => found <= bound as usize,
        };
        if is_right { Ok(()) } else { Err(Violation::Length { found, unit: "elements", shape: self.shape }) }
    }

    /// Checks all bytes of a text. The text must fill its array.
    pub fn check_array(self, bytes: &[u8]) -> Result<(), Violation<'t>> {
        if let Element::Text(room) = self.element
            && bytes.len() != room as usize
        {
            return Err(Violation::Length { found: bytes.len(), unit: "bytes", shape: Shape::Array(room) });
        }
        check_text(bytes)
    }
}

impl Field {
    /// The type of the field's values, with its constraints.
    pub fn value_type(&self) -> ValueType<'_> {
        ValueType { element: self.element, shape: self.shape, restriction: self.restriction.as_ref() }
    }
}

impl Violation<'_> {
    /// The violated constraint. `None` if decoders reject the value, so no message can contain it.
    pub fn kind(&self) -> Option<ConstraintKind> {
        match self {
            Self::Number(kind, ..) => Some(*kind),
            Self::Length { .. } => Some(ConstraintKind::Bound),
            Self::NotUtf8(_) | Self::NotUtf16(_) => Some(ConstraintKind::Text),
            Self::Bool(_) | Self::Type | Self::TooLarge(_) | Self::Nul(_) => None,
        }
    }
}

impl Leaf<'_> {
    /// The little-endian bytes of the value in memory. The value must fit into this type.
    pub fn bytes(self, scalar: Scalar) -> [u8; 8] {
        let number = match self {
            Self::Null => Number::Float(f64::NAN),
            Self::Bool(value) => Number::Int(value.into()),
            Self::Int(value) => Number::Int(value),
            Self::Float(value) if scalar.is_float() => Number::Float(value),
            Self::Float(value) => Number::Int(whole(value).unwrap_or_default()),
            Self::Text(_) => Number::Int(0),
        };
        number_bytes(scalar, number)
    }

    /// The value of an integer in any notation: JSON Schema accepts `5.0` as an integer.
    pub fn integer(self) -> Option<i128> {
        match self {
            Self::Int(value) => Some(value),
            Self::Float(value) => whole(value),
            _ => None,
        }
    }
}

/// The value of a number as an integer, if the number has no fraction.
pub fn whole(value: f64) -> Option<i128> {
    #[allow(clippy::cast_possible_truncation)] // within bounds
    (value.fract() == 0.0 && value.abs() < 1e30).then_some(value as i128)
}

/// Checks the bytes of a text up to the first NUL.
fn check_text<'t>(bytes: &[u8]) -> Result<(), Violation<'t>> {
    match std::str::from_utf8(until_nul(bytes)) {
        Ok(_) => Ok(()),
        Err(error) => Err(Violation::NotUtf8(error.valid_up_to())),
    }
}

/// Checks the bytes of a string in memory. A `wstring` in memory is UTF-8, except for unpaired surrogates.
fn check_string<'t>(bytes: &[u8], bounds: Bounds) -> Result<(), Violation<'t>> {
    check_characters(bytes, bounds)?;
    let Err(error) = std::str::from_utf8(bytes) else { return Ok(()) };
    if !bounds.is_wide {
        return Err(Violation::NotUtf8(error.valid_up_to()));
    }
    let before = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    Err(Violation::NotUtf16(before.encode_utf16().count()))
}

/// Checks the number of characters of a string.
fn check_characters<'t>(text: &[u8], bounds: Bounds) -> Result<(), Violation<'t>> {
    match bounds.exceeded_by(text) {
        Some((bound, found)) => {
            Err(Violation::Length { found, unit: "characters", shape: Shape::Bounded(bound) })
        }
        None => Ok(()),
    }
}

/// The value as a float of the type `scalar`. The value is rounded first, since ranges and special values apply to the
/// rounded value.
fn float<'t>(scalar: Scalar, leaf: Leaf<'_>) -> Result<Number, Violation<'t>> {
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

/// The number with these little-endian bytes. A `bool` has the value of its byte. `None` if there are too few bytes.
pub fn number(scalar: Scalar, bytes: &[u8]) -> Option<Number> {
    let bytes = bytes.get(..scalar.size())?;
    match scalar {
        Scalar::Bool => Some(Number::Int(bytes[0].into())),
        _ => scalar_value(scalar, bytes).number(),
    }
}
