//! Numbers in constraints.

use uavspec_runtime::{Number, Scalar};

use crate::msg::literal::{LiteralError, parse_scalar};
use crate::value::Value;

/// Names of C integer limits, which definitions use as invalid values and as bounds.
const LIMITS: [(&str, Scalar); 8] = [
    ("UINT8_MAX", Scalar::UInt8),
    ("UINT16_MAX", Scalar::UInt16),
    ("UINT32_MAX", Scalar::UInt32),
    ("UINT64_MAX", Scalar::UInt64),
    ("INT8_MAX", Scalar::Int8),
    ("INT16_MAX", Scalar::Int16),
    ("INT32_MAX", Scalar::Int32),
    ("INT64_MAX", Scalar::Int64),
];

/// Parses a number in an annotation: an integer, a float, the name of a limit, or a multiple of pi.
pub(super) fn parse(text: &str) -> Result<Value, LiteralError> {
    if let Some((_, scalar)) = LIMITS.iter().find(|(name, _)| *name == text) {
        let (_, max) = scalar.integer_bounds().ok_or(LiteralError::Form)?;
        return Ok(Value::Int(max));
    }
    let lower = text.to_ascii_lowercase();
    if let Some(factor) = lower.strip_suffix("pi") {
        let factor = match factor.trim_end_matches(['*', ' ']) {
            "" | "+" => 1.0,
            "-" => -1.0,
            digits => digits.parse::<f64>().map_err(|_| LiteralError::Form)?,
        };
        return Ok(Value::Float(factor * std::f64::consts::PI));
    }
    parse_scalar(text, Scalar::Int64)
        .or_else(|_| parse_scalar(text, Scalar::UInt64))
        .or_else(|_| parse_scalar(text, Scalar::Float64))
}

/// The value as stored in a field of type `scalar`.
pub(crate) fn stored(value: &Value, scalar: Scalar) -> Option<Number> {
    let number = value.number()?;
    match value.as_f64() {
        #[allow(clippy::cast_possible_truncation)] // rounding is intended
        Some(value) if scalar == Scalar::Float32 => Some(Number::Float(f64::from(value as f32))),
        Some(value) if scalar == Scalar::Float64 => Some(Number::Float(value)),
        _ => Some(number),
    }
}

/// The smallest and greatest JSON numbers that can represent `number` in a field of type `scalar`.
///
/// A `float32` can't represent pi exactly. Writers widen the `float32` to 64 bits (3.1415927410125732) or use its
/// shortest form (3.1415927). Both numbers are greater than pi.
pub fn spread(number: Number, scalar: Scalar) -> (Number, Number) {
    /// The greatest `float32`, in its shortest form.
    const MAX_FLOAT32: f64 = 3.402_823_5e38;
    let exact = number.as_f64();
    let is_inexact = scalar == Scalar::Float32 && exact.abs() < MAX_FLOAT32;
    if !is_inexact {
        return (number, number);
    }
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    let rounded = exact as f32;
    let widened = f64::from(rounded);
    let shortest = rounded.to_string().parse().unwrap_or(widened);
    let (low, high) = (widened.min(shortest), widened.max(shortest));
    let low = if low < exact { Number::Float(low) } else { number };
    let high = if high > exact { Number::Float(high) } else { number };
    (low, high)
}
