//! Copies and slices of buffers.

use uavspec_runtime::record::Primitive;

use super::step::Width;

/// Copies numbers. If `BIG`, reverses the bytes of each number.
#[inline]
pub(super) fn copy<const BIG: bool>(from: &[u8], to: &mut [u8], width: Width) {
    if BIG { copy_swapped(from, to, width) } else { copy_short(from, to) }
}

/// Copies bytes. Short runs, which are the most common, are copied without a call to `memcpy`.
#[inline]
pub(crate) fn copy_short(from: &[u8], to: &mut [u8]) {
    match from.len() {
        8..=16 => copy_ends::<8>(from, to),
        4..=7 => copy_ends::<4>(from, to),
        2..=3 => copy_ends::<2>(from, to),
        1 => copy_ends::<1>(from, to),
        _ => to.copy_from_slice(from),
    }
}

/// Copies the first `N` and the last `N` bytes. If the slice has `N` to `2 * N` bytes, this copies all of them.
#[inline]
fn copy_ends<const N: usize>(from: &[u8], to: &mut [u8]) {
    if let (Some(from), Some(to)) = (from.first_chunk::<N>(), to.first_chunk_mut()) {
        *to = *from;
    }
    if let (Some(from), Some(to)) = (from.last_chunk::<N>(), to.last_chunk_mut()) {
        *to = *from;
    }
}

fn copy_swapped(from: &[u8], to: &mut [u8], width: Width) {
    match width {
        Width::One => copy_short(from, to),
        Width::Two => swap::<2>(from, to),
        Width::Four => swap::<4>(from, to),
        Width::Eight => swap::<8>(from, to),
    }
}

#[inline]
fn swap<const N: usize>(from: &[u8], to: &mut [u8]) {
    for (from, to) in from.as_chunks::<N>().0.iter().zip(to.as_chunks_mut::<N>().0) {
        *to = *from;
        to.reverse();
    }
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
