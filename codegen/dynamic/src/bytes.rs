//! Slices of buffers, and the bytes of numbers.

use uavspec_runtime::record::Primitive;
use uavspec_runtime::{Number, Scalar};

/// Reverses the bytes of each number. `size` is the size of a number.
pub(super) fn reverse_each(numbers: &mut [u8], size: usize) {
    numbers.chunks_exact_mut(size).for_each(<[u8]>::reverse);
}

/// The offset of a sequence's first element, and the number of elements. `at` is the offset of the sequence.
pub fn sequence(memory: &[u8], at: usize) -> (usize, usize) {
    slot(memory, at)
}

/// Reads a slot: the offset of the first byte or element, and the number of bytes or elements.
#[inline]
pub(super) fn slot(bytes: &[u8], at: usize) -> (usize, usize) {
    let number = |at| u32::read_le(part(bytes, at, 4)) as usize;
    (number(at), number(at + 4))
}

/// Returns `length` bytes from `start`, or an empty slice if this range exceeds the buffer.
#[inline]
pub(crate) fn part(bytes: &[u8], start: usize, length: usize) -> &[u8] {
    bytes.get(start..start + length).unwrap_or_default()
}

/// The little-endian bytes of a number, limited to the range of its type. Only as many of the first bytes are used as
/// the type has.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)]
pub(crate) fn number_bytes(scalar: Scalar, number: Number) -> [u8; 8] {
    let float = |value: f64| match scalar {
        Scalar::Float32 => u64::from((value as f32).to_bits()),
        _ => value.to_bits(),
    };
    let bits = match (number, scalar.integer_bounds()) {
        (Number::Int(value), _) if scalar == Scalar::Bool => u64::from(value != 0),
        // The truncation keeps the bytes of the type.
        (Number::Int(value), Some((low, high))) => value.clamp(low, high) as u64,
        (Number::Int(value), None) => float(value as f64),
        (Number::Float(value), _) => float(value),
    };
    bits.to_le_bytes()
}

/// The text in a `char[N]`: all bytes before the first NUL.
pub(super) fn until_nul(bytes: &[u8]) -> &[u8] {
    bytes.split(|byte| *byte == 0).next().unwrap_or_default()
}

/// Normalizes each byte to 0 or 1.
pub(super) fn make_bools(bytes: &mut [u8]) {
    for byte in bytes {
        *byte = u8::from(*byte != 0);
    }
}
