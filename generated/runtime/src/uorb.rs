//! The memory layout of fixed-size messages, as transported by uORB and stored in `ULog` files.
//!
//! Numbers are little-endian, at the offsets of [`layout`](crate::layout). A payload may omit the padding at its end.
//! Encoding writes padding as zeros, and decoding ignores it.

use crate::descriptor::MessageDescriptor;
use crate::error::{DecodeError, Fault};
use crate::fixed::{self, Encoding};
use crate::layout::Size;
use crate::record::Primitive;
use crate::{Path, UorbMessage};

/// The bytes of all fields of a message: the payload without the padding at its end.
#[inline]
pub(crate) fn payload<T: UorbMessage>(bytes: &[u8]) -> Result<&[u8], DecodeError> {
    let has_size = bytes.len() == T::SIZE || bytes.len() == T::SIZE_NO_PADDING;
    match bytes.get(..T::SIZE_NO_PADDING) {
        Some(fields) if has_size => Ok(fields),
        _ => {
            let size = Size { padded: T::SIZE, no_padding: T::SIZE_NO_PADDING };
            Err(wrong_size(T::DESCRIPTOR, size, bytes.len()))
        }
    }
}

#[cold]
fn wrong_size(message: &'static MessageDescriptor, size: Size, found: usize) -> DecodeError {
    let Size { padded, no_padding } = size;
    let offset = found.min(padded);
    DecodeError { fault: Fault::Size { padded, no_padding, found }, offset, path: Path::to(message) }
}

/// Decodes a message. In strict mode each `bool` must be 0 or 1.
#[inline]
pub(crate) fn decode<T: UorbMessage, const STRICT: bool>(bytes: &[u8]) -> Result<T, DecodeError> {
    let bytes = payload::<T>(bytes)?;
    let mut failure = None;
    let message = fixed::read::<T, Memory, STRICT>(bytes, &mut failure);
    match failure {
        None => Ok(message),
        Some(error) => Err(error),
    }
}

/// Reads all fields of a message. A `bool` is true if its byte is not 0.
#[cfg(feature = "views")]
#[inline]
pub(crate) fn read<T: crate::record::Record>(bytes: &[u8]) -> T {
    fixed::read::<T, Memory, false>(bytes, &mut None)
}

/// Encodes a message. `bytes` must have the size of the message and be all zeros.
#[inline]
pub(crate) fn encode<T: UorbMessage>(message: &T, bytes: &mut [u8]) {
    let bytes = bytes.get_mut(..T::SIZE_NO_PADDING).unwrap_or_default();
    fixed::write::<T, Memory>(message, bytes);
}

/// The memory layout.
struct Memory;

impl Encoding for Memory {
    const HAS_OFFSETS: bool = true;

    #[inline]
    fn start(at: usize, _: usize) -> usize {
        at
    }

    #[inline]
    fn read<P: Primitive>(bytes: &[u8]) -> P {
        P::read_le(bytes)
    }

    #[inline]
    fn write<P: Primitive>(number: P, bytes: &mut [u8]) {
        number.write_le(bytes);
    }
}

/// A byte array for a payload.
pub trait Bytes: AsRef<[u8]> + AsMut<[u8]> + Copy {
    /// An array of zeros.
    const ZEROS: Self;
}

impl<const N: usize> Bytes for [u8; N] {
    const ZEROS: Self = [0; N];
}
