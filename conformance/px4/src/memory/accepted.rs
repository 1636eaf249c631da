//! A fast check of values in memory. Most values pass, and only the others are examined further.

use uavspec_dynamic::{ValueType, number};
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::{Element, Restriction};

/// A fast check that only accepts values without findings. Most values need at most two comparisons.
#[derive(Clone, Copy, Debug)]
pub(super) enum Accepted {
    /// The bytes 0 and 1.
    Bool,
    /// UTF-8 text up to the first NUL.
    Text,
    /// A string without invalid UTF-8.
    String,
    /// Integers between two bounds, inclusive.
    Between(Scalar, i64, i64),
    /// Bytes from a set, with a bit for each byte.
    Among([u64; 4]),
    /// Floats between two bounds, inclusive. NaN needs the full check.
    Floats(Scalar, f64, f64),
    /// All values need the full check.
    Unknown,
}

/// Values at fixed offsets of a payload, with the same check.
#[derive(Debug)]
pub(super) struct Block {
    /// The offset of the first value.
    pub(super) offset: usize,
    pub(super) count: usize,
    /// The distance from one value to the next.
    pub(super) stride: usize,
    /// The size of a value.
    pub(super) width: usize,
    pub(super) accepted: Accepted,
}

impl Block {
    /// Joins bools that follow each other. Many messages consist of bools.
    pub(super) fn merge(blocks: Vec<Self>) -> Vec<Self> {
        let mut merged: Vec<Self> = Vec::new();
        for block in blocks {
            match (merged.last_mut(), &block.accepted) {
                (Some(before @ Self { accepted: Accepted::Bool, .. }), Accepted::Bool)
                    if before.offset + before.count == block.offset =>
                {
                    before.count += block.count;
                }
                _ => merged.push(block),
            }
        }
        merged
    }

    /// True if the payload contains the values, and none of them produces findings.
    #[inline]
    pub(super) fn accepts(&self, payload: &[u8]) -> bool {
        let Self { offset, count, stride, width, accepted } = self;
        let mut starts = (0..*count).map(|index| offset + index * stride);
        match accepted {
            Accepted::Bool => {
                let bools = payload.get(*offset..offset + count);
                bools.is_some_and(|bools| bools.iter().fold(0, |all, byte| all | byte) < 2)
            }
            Accepted::Among(set) => {
                starts.all(|start| payload.get(start).is_some_and(|byte| contains(set, *byte)))
            }
            _ => starts
                .all(|start| payload.get(start..start + width).is_some_and(|value| accepted.accepts(value))),
        }
    }
}

/// True if a byte is in a set, which has a bit for each byte.
#[inline]
fn contains(set: &[u64; 4], byte: u8) -> bool {
    set[usize::from(byte / 64)] >> (byte % 64) & 1 == 1
}

impl Accepted {
    /// Derives the fast check from a constraint. To verify the derived ranges, their ends are checked against the
    /// constraint. `None` if nothing is constrained.
    pub(super) fn new(value: ValueType<'_>) -> Option<Self> {
        let scalar = match value.element {
            Element::Scalar(Scalar::Bool) => return Some(Self::Bool),
            Element::Text(_) => return Some(Self::Text),
            Element::String { .. } => return Some(Self::String),
            Element::Scalar(scalar) => scalar,
            Element::Message(_) => return None,
        };
        let restriction = value.restriction?;
        if restriction.constraint() == uavspec_runtime::Constraint::NONE {
            return None;
        }
        if let Scalar::UInt8 | Scalar::Byte | Scalar::Char | Scalar::Int8 = scalar {
            let is_accepted =
                |byte: usize| u8::try_from(byte).is_ok_and(|byte| value.check_bytes(&[byte]).is_ok());
            let bits = |word| {
                (0..64).filter(|bit| is_accepted(64 * word + bit)).fold(0, |bits, bit| bits | 1 << bit)
            };
            return Some(Self::Among(std::array::from_fn(bits)));
        }
        let is_accepted = |number: Number| value.check_number(number).is_ok();
        let accepted = if !restriction.constraint().is_interval() {
            None
        } else if scalar.is_float() {
            Some(Self::floats(scalar, restriction))
        } else {
            Self::integers(scalar, restriction)
        };
        let are_ends_accepted = match &accepted {
            Some(Self::Between(_, low, high)) => {
                [*low, *high].map(|end| Number::Int(end.into())).into_iter().all(is_accepted)
            }
            Some(Self::Floats(_, low, high)) => [*low, *high].map(Number::Float).into_iter().all(is_accepted),
            _ => false,
        };
        Some(accepted.filter(|_| are_ends_accepted).unwrap_or(Self::Unknown))
    }

    fn floats(scalar: Scalar, restriction: &Restriction) -> Self {
        let bound = |number: Option<Number>, default: f64| match number {
            None => default,
            #[allow(clippy::cast_precision_loss)] // the ends are verified later
            Some(Number::Int(value)) => value as f64,
            Some(Number::Float(value)) => value,
        };
        let low = bound(restriction.limits.low, f64::NEG_INFINITY);
        Self::Floats(scalar, low, bound(restriction.limits.high, f64::INFINITY))
    }

    fn integers(scalar: Scalar, restriction: &Restriction) -> Option<Self> {
        let bound = |number: Option<Number>, default: i64| match number {
            None => Some(default),
            Some(Number::Int(value)) => i64::try_from(value).ok(),
            Some(Number::Float(_)) => None,
        };
        let high = match (restriction.limits.high, restriction.limits.count) {
            (None, Some(count)) => Some(Number::Int(count.into())),
            (high, None) => high,
            (Some(_), Some(_)) => return None,
        };
        let (low, high) = (bound(restriction.limits.low, i64::MIN)?, bound(high, i64::MAX)?);
        let is_plain = scalar != Scalar::UInt64;
        is_plain.then_some(Self::Between(scalar, low, high))
    }

    /// True if the value is guaranteed to produce no findings.
    #[inline]
    pub(super) fn accepts(&self, value: &[u8]) -> bool {
        match self {
            Self::Bool => value[0] < 2,
            Self::Text => std::str::from_utf8(until_nul(value)).is_ok(),
            Self::String => std::str::from_utf8(value).is_ok(),
            Self::Between(scalar, low, high) => {
                integer(*scalar, value).is_some_and(|value| (*low..=*high).contains(&value))
            }
            Self::Among(set) => contains(set, value[0]),
            Self::Floats(scalar, low, high) => {
                float(*scalar, value).is_some_and(|value| *low <= value && value <= *high)
            }
            Self::Unknown => false,
        }
    }
}

fn until_nul(text: &[u8]) -> &[u8] {
    text.iter().position(|byte| *byte == 0).map_or(text, |end| &text[..end])
}

fn integer(scalar: Scalar, bytes: &[u8]) -> Option<i64> {
    match number(scalar, bytes)? {
        Number::Int(value) => i64::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

fn float(scalar: Scalar, bytes: &[u8]) -> Option<f64> {
    match scalar {
        Scalar::Float32 => Some(f32::from_le_bytes(bytes.try_into().ok()?).into()),
        Scalar::Float64 => Some(f64::from_le_bytes(bytes.try_into().ok()?)),
        _ => None,
    }
}
