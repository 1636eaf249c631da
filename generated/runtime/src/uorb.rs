//! The memory layout of fixed-size messages, as transported by uORB and stored in `ULog` files.
//!
//! Numbers are little-endian, at the offsets of [`layout`](crate::layout). A payload may omit the padding at its end.
//! Encoding writes padding as zeros, and decoding ignores it.
//!
//! ```
//! use uavspec_runtime::uorb::Elements;
//! use uavspec_runtime::{Definition, Message, UorbMessage, record};
//!
//! #[derive(Clone, Debug, Default, PartialEq)]
//! pub struct Wind {
//!     pub timestamp: u64,
//!     pub speed: [f32; 2],
//! }
//!
//! impl Message for Wind {
//!     const DEFINITION: Definition = Definition::new("example", "Wind");
//! }
//!
//! record! {
//!     Wind[2], WindView, 16, 16;
//!     0 timestamp: u64 = uint64("timestamp", 0);
//!     1 speed: Elements<'b, f32, 2> = float32("speed", 8).array(2);
//! }
//!
//! let payload = Wind { timestamp: 1, speed: [2.0, 3.0] }.to_uorb();
//! let view = Wind::view(&payload)?;
//! assert_eq!((view.timestamp(), view.speed().get(1)), (1, Some(3.0)));
//! # Ok::<(), uavspec_runtime::DecodeError>(())
//! ```

use core::fmt;
use core::marker::PhantomData;

use crate::descriptor::MessageDescriptor;
use crate::error::{DecodeError, Fault};
use crate::fixed::{self, Encoding};
use crate::layout::Size;
use crate::record::{Primitive, Record};
use crate::{Path, Text, UorbMessage};

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

/// The content of a view type: the `N` bytes of a payload that contain the fields of message `M`.
#[doc(hidden)]
pub struct Fields<'b, M, const N: usize> {
    bytes: &'b [u8; N],
    message: PhantomData<M>,
}

impl<M, const N: usize> Clone for Fields<'_, M, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, const N: usize> Copy for Fields<'_, M, N> {}

impl<'b, M: Record, const N: usize> Fields<'b, M, N> {
    /// The message at `offset`. All zeros if there are too few bytes, which can't happen in generated code.
    #[inline]
    pub fn at(bytes: &'b [u8], offset: usize) -> Self {
        let bytes = bytes.get(offset..).and_then(<[u8]>::first_chunk).unwrap_or(&[0; N]);
        Self { bytes, message: PhantomData }
    }

    /// The view of the field with this index.
    #[inline]
    pub fn get<V: View<'b>>(self, index: usize) -> V {
        V::at(self.bytes, M::DESCRIPTOR.fields[index].offset)
    }

    /// The whole message.
    #[inline]
    pub fn read(self) -> M {
        fixed::read::<M, Memory, false>(self.bytes, &mut None)
    }
}

/// Formats the message.
impl<M: Record + fmt::Debug, const N: usize> fmt::Debug for Fields<'_, M, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.read().fmt(formatter)
    }
}

/// A value that is read from a payload on access.
///
/// Numbers, enums and text are their own views. [`Elements`] is the view of an array, and each message has a view type.
pub trait View<'b>: Copy {
    /// Distance between the elements of an array, in bytes.
    const STRIDE: usize;

    /// The value at `offset`. Zero if there are too few bytes.
    fn at(bytes: &'b [u8], offset: usize) -> Self;
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl View<'_> for $type {
            const STRIDE: usize = <Self as Primitive>::SIZE;

            #[inline]
            fn at(bytes: &[u8], offset: usize) -> Self {
                Self::read_le(bytes.get(offset..).unwrap_or_default())
            }
        }
    )*};
}

numbers!(bool, u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

impl<const N: usize> View<'_> for Text<N> {
    const STRIDE: usize = N;

    #[inline]
    fn at(bytes: &[u8], offset: usize) -> Self {
        bytes.get(offset..).and_then(<[u8]>::first_chunk).map_or_else(Self::default, |bytes| Self(*bytes))
    }
}

impl<'b, V: View<'b>, const N: usize> View<'b> for Elements<'b, V, N> {
    const STRIDE: usize = V::STRIDE.saturating_mul(N);

    #[inline]
    fn at(bytes: &'b [u8], offset: usize) -> Self {
        Self { bytes: bytes.get(offset..).unwrap_or_default(), element: PhantomData }
    }
}

/// A view of an array of `N` elements. `V` is the view of an element.
pub struct Elements<'b, V, const N: usize> {
    /// The bytes from the first element to the end of the message.
    bytes: &'b [u8],
    element: PhantomData<V>,
}

impl<V, const N: usize> Clone for Elements<'_, V, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<V, const N: usize> Copy for Elements<'_, V, N> {}

impl<'b, V: View<'b>, const N: usize> Elements<'b, V, N> {
    /// The number of elements, `N`.
    pub const fn len(self) -> usize {
        N
    }

    /// True if `N` is 0.
    pub const fn is_empty(self) -> bool {
        N == 0
    }

    /// The element with this index, or `None` if `index` is not less than `N`.
    #[inline]
    pub fn get(self, index: usize) -> Option<V> {
        (index < N).then(|| V::at(self.bytes, index * V::STRIDE))
    }

    /// All elements in order.
    #[inline]
    pub fn iter(self) -> impl ExactSizeIterator<Item = V> + DoubleEndedIterator {
        (0..N).map(move |index| V::at(self.bytes, index * V::STRIDE))
    }
}

impl<'b, const N: usize> Elements<'b, u8, N> {
    /// The elements as a byte slice.
    pub fn as_bytes(self) -> &'b [u8] {
        self.bytes.get(..N).unwrap_or_default()
    }
}

impl<'b, V: View<'b> + fmt::Debug, const N: usize> fmt::Debug for Elements<'b, V, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.iter()).finish()
    }
}
