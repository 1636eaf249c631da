//! Conversion of numbers and text in memory.

use uavspec_runtime::Scalar;
use uavspec_runtime::record::Primitive;

use crate::conversion::expression::Computed;
use crate::conversion::plan::{CountLimit, Elements, Narrowing};

/// The conversion of a number.
#[derive(Debug)]
pub(super) struct Number {
    pub(super) from: Scalar,
    pub(super) to: Scalar,
    pub(super) elements: Elements,
    pub(super) limit: Option<CountLimit>,
}

impl Number {
    /// The converted value; `None` for the neutral value.
    pub(super) fn converted(&self, value: Computed) -> Option<Computed> {
        let value = match (&self.elements, value) {
            // The limit of a count also converts the named values.
            (Elements::Values(pairs), Computed::Int(value)) if self.limit.is_none() => {
                Computed::Int(pairs.iter().find(|(from, _)| *from == value).map_or(value, |(_, to)| *to))
            }
            (Elements::Flags(pairs), Computed::Int(value)) => Computed::Int(flags(pairs, value)),
            (Elements::Narrow(Narrowing::Neutral), Computed::Int(value)) => {
                let (low, high) = self.to.integer_bounds()?;
                Computed::Int((low..=high).contains(&value).then_some(value)?)
            }
            (_, value) => value,
        };
        Some(match (&self.limit, value) {
            (Some(limit), Computed::Int(value)) => Computed::Int(limit.limited(value)),
            (_, value) => value,
        })
    }
}

/// Moves flags to their target masks. Other bits stay the same.
fn flags(pairs: &[(i128, i128)], value: i128) -> i128 {
    let moved = pairs.iter().fold(0, |all, (from, _)| all | from);
    let set = pairs.iter().filter(|(from, _)| value & from == *from && *from != 0);
    set.fold(value & !moved, |all, (_, to)| all | to)
}

/// The number in the first bytes. Missing bytes are 0.
pub(super) fn read(scalar: Scalar, bytes: &[u8]) -> Computed {
    let mut padded = [0; 8];
    for (to, from) in padded.iter_mut().zip(bytes.iter().take(scalar.size())) {
        *to = *from;
    }
    let bytes = &padded[..scalar.size()];
    match scalar {
        Scalar::Bool => Computed::Bool(bytes[0] != 0),
        Scalar::Byte | Scalar::Char | Scalar::UInt8 => Computed::Int(bytes[0].into()),
        Scalar::Int8 => Computed::Int(i8::read_le(bytes).into()),
        Scalar::Int16 => Computed::Int(i16::read_le(bytes).into()),
        Scalar::UInt16 => Computed::Int(u16::read_le(bytes).into()),
        Scalar::Int32 => Computed::Int(i32::read_le(bytes).into()),
        Scalar::UInt32 => Computed::Int(u32::read_le(bytes).into()),
        Scalar::Int64 => Computed::Int(i64::read_le(bytes).into()),
        Scalar::UInt64 => Computed::Int(u64::read_le(bytes).into()),
        Scalar::Float32 => Computed::Float(f32::read_le(bytes).into()),
        Scalar::Float64 => Computed::Float(f64::read_le(bytes)),
    }
}

/// The bytes of a number in the range of a type, followed by zeros.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]
pub(super) fn write(scalar: Scalar, value: Computed) -> [u8; 8] {
    let float = |value: f64| match scalar {
        Scalar::Float32 => u64::from((value as f32).to_bits()).to_le_bytes(),
        _ => value.to_bits().to_le_bytes(),
    };
    match (value, scalar.integer_bounds()) {
        (Computed::Bool(value), _) => u64::from(value).to_le_bytes(),
        (Computed::Int(value), _) if scalar == Scalar::Bool => u64::from(value != 0).to_le_bytes(),
        // The truncation keeps the bytes of the type.
        (Computed::Int(value), Some((low, high))) => (value.clamp(low, high) as u64).to_le_bytes(),
        (Computed::Int(value), None) => float(value as f64),
        (Computed::Float(value), _) => float(value),
    }
}

/// The text in a `char[N]`, cut to at most `length` bytes without an incomplete character.
pub(super) fn text(bytes: &[u8], length: usize) -> &[u8] {
    let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    let mut end = text.len().min(length);
    // A character has at most three continuation bytes.
    for _ in 0..3 {
        if end == 0 || text.get(end).is_none_or(|byte| byte & 0xc0 != 0x80) {
            break;
        }
        end -= 1;
    }
    &text[..end]
}

/// The first characters of a string.
pub(super) fn characters(text: &[u8], bound: Option<u32>) -> &[u8] {
    let Some(bound) = bound.map(|bound| bound as usize).filter(|bound| text.len() > *bound) else {
        return text;
    };
    let end: usize = crate::characters(text).take(bound).map(<[u8]>::len).sum();
    &text[..end]
}
