//! The memory form of messages of fixed size: what uORB carries, and `ULog` records.
//!
//! Little-endian, at the offsets of [`layout`](crate::layout). A payload has the full size or lacks
//! the padding at its end. Padding is written as zeros and read as anything.
//!
//! ```
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
//!     Wind, WindView, 16, 16;
//!     0 timestamp: u64 = uint64("timestamp", 0);
//!     1 speed: [f32; 2] = float32("speed", 8).array(2);
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
use crate::fixed::{self, Form};
use crate::layout::Size;
use crate::record::{Primitive, Record, Value};
use crate::{Path, Text, UorbMessage};

/// The bytes that hold all fields of a message: the payload without the padding at its end.
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

/// Reads a message; in strict mode each `bool` must be 0 or 1.
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

/// Writes a message to `bytes`, which are zeros, as many as its size.
#[inline]
pub(crate) fn encode<T: UorbMessage>(message: &T, bytes: &mut [u8]) {
    let bytes = bytes.get_mut(..T::SIZE_NO_PADDING).unwrap_or_default();
    fixed::write::<T, Memory>(message, bytes);
}

/// The form in memory.
struct Memory;

impl Form for Memory {
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

/// An array of bytes that holds a payload.
pub trait Bytes: AsRef<[u8]> + AsMut<[u8]> + Copy {
    /// Zeros.
    const ZEROS: Self;
}

impl<const N: usize> Bytes for [u8; N] {
    const ZEROS: Self = [0; N];
}

/// The fields of a message of type `M` in `N` bytes of a payload: the content of its view type.
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
    /// The message at `offset`; zeros if there are too few bytes, which generated code can't cause.
    #[inline]
    pub fn at(bytes: &'b [u8], offset: usize) -> Self {
        let bytes = bytes.get(offset..).and_then(<[u8]>::first_chunk).unwrap_or(&[0; N]);
        Self { bytes, message: PhantomData }
    }

    /// The view of field `index`, which has the type `T`.
    #[inline]
    pub fn get<T: Viewed>(self, index: usize) -> T::View<'b> {
        <T as Viewed>::view_at(self.bytes, M::DESCRIPTOR.fields[index].offset)
    }

    /// The whole message.
    #[inline]
    pub fn read(self) -> M {
        fixed::read::<M, Memory, false>(self.bytes, &mut None)
    }
}

/// The message itself.
impl<M: Record + fmt::Debug, const N: usize> fmt::Debug for Fields<'_, M, N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.read().fmt(formatter)
    }
}

/// A type of fixed size that can be looked at in the bytes of a message, without reading all of it.
pub trait Viewed: Value {
    /// What is seen: of numbers, enums and text the value itself, of arrays [`Elements`], of messages
    /// their view type.
    type View<'b>;
    /// Bytes from one element of an array to the next.
    const STRIDE: usize;

    /// Looks at the value at `offset`.
    fn view_at(bytes: &[u8], offset: usize) -> Self::View<'_>;
}

/// What the view of a message gives for a field of type `T`.
pub type View<'b, T> = <T as Viewed>::View<'b>;

macro_rules! viewed_numbers {
    ($($type:ty),*) => {$(
        impl Viewed for $type {
            type View<'b> = Self;
            const STRIDE: usize = <Self as Primitive>::SIZE;

            #[inline]
            fn view_at(bytes: &[u8], offset: usize) -> Self {
                Self::read_le(bytes.get(offset..).unwrap_or_default())
            }
        }
    )*};
}

viewed_numbers!(bool, u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

impl<T: UorbMessage> Viewed for T {
    type View<'b> = T::View<'b>;
    const STRIDE: usize = T::SIZE;

    #[inline]
    fn view_at(bytes: &[u8], offset: usize) -> T::View<'_> {
        T::view_at(bytes, offset)
    }
}

impl<const N: usize> Viewed for Text<N> {
    type View<'b> = Self;
    const STRIDE: usize = N;

    #[inline]
    fn view_at(bytes: &[u8], offset: usize) -> Self {
        bytes.get(offset..).and_then(<[u8]>::first_chunk).map_or_else(Self::default, |bytes| Self(*bytes))
    }
}

impl<T: Viewed, const N: usize> Viewed for [T; N] {
    type View<'b> = Elements<'b, T, N>;
    const STRIDE: usize = T::STRIDE.saturating_mul(N);

    #[inline]
    fn view_at(bytes: &[u8], offset: usize) -> Elements<'_, T, N> {
        Elements { bytes: bytes.get(offset..).unwrap_or_default(), element: PhantomData }
    }
}

/// An array of `N` in the bytes of a message.
pub struct Elements<'b, T, const N: usize> {
    /// From the first element to the end of the message.
    bytes: &'b [u8],
    element: PhantomData<T>,
}

impl<T, const N: usize> Clone for Elements<'_, T, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T, const N: usize> Copy for Elements<'_, T, N> {}

impl<'b, T: Viewed, const N: usize> Elements<'b, T, N> {
    /// The number of elements, `N`.
    pub const fn len(self) -> usize {
        N
    }

    /// Whether there is no element.
    pub const fn is_empty(self) -> bool {
        N == 0
    }

    /// The element `index`, if it is under `N`.
    #[inline]
    pub fn get(self, index: usize) -> Option<View<'b, T>> {
        (index < N).then(|| <T as Viewed>::view_at(self.bytes, index * T::STRIDE))
    }

    /// All elements in order.
    #[inline]
    pub fn iter(self) -> impl ExactSizeIterator<Item = View<'b, T>> + DoubleEndedIterator {
        (0..N).map(move |index| <T as Viewed>::view_at(self.bytes, index * T::STRIDE))
    }
}

impl<'b, const N: usize> Elements<'b, u8, N> {
    /// The bytes themselves.
    pub fn as_bytes(self) -> &'b [u8] {
        self.bytes.get(..N).unwrap_or_default()
    }
}

impl<'b, T: Viewed, const N: usize> fmt::Debug for Elements<'b, T, N>
where
    View<'b, T>: fmt::Debug,
{
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.iter()).finish()
    }
}
