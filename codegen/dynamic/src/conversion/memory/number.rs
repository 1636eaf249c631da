//! Conversion of numbers and text in memory.

use uavspec_runtime::{Number as Plain, Scalar};

use crate::conversion::expression::Computed;
use crate::conversion::plan::{CountLimit, Elements, Narrowing};
use crate::number_bytes;
use crate::view::{Value, scalar_value};

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
            // A limit of a count also converts the named values, so this case applies only without
            // a limit.
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

/// The number in the first bytes, or 0 if there are too few bytes.
pub(super) fn read(scalar: Scalar, bytes: &[u8]) -> Computed {
    let value = scalar_value(scalar, bytes);
    match (value, value.number()) {
        (Value::Bool(value), _) => Computed::Bool(value),
        (_, Some(Plain::Float(value))) => Computed::Float(value),
        (_, Some(Plain::Int(value))) => Computed::Int(value),
        (_, None) => Computed::Int(0),
    }
}

/// The bytes of a number in the range of a type, followed by zeros.
pub(super) fn write(scalar: Scalar, value: Computed) -> [u8; 8] {
    let number = match value {
        Computed::Bool(value) => Plain::Int(value.into()),
        Computed::Int(value) => Plain::Int(value),
        Computed::Float(value) => Plain::Float(value),
    };
    number_bytes(scalar, number)
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

/// The first `bound` characters of a string, or all characters without a bound.
pub(super) fn characters(text: &[u8], bound: Option<u32>) -> &[u8] {
    let Some(bound) = bound.map(|bound| bound as usize).filter(|bound| text.len() > *bound) else {
        return text;
    };
    let end: usize = crate::characters(text).take(bound).map(<[u8]>::len).sum();
    &text[..end]
}
