//! The memory form of messages of fixed size: what uORB carries, and `ULog` records.
//!
//! Little-endian, at the offsets of [`layout`](crate::layout). A payload has the full size or lacks
//! the padding at its end. Padding is written as zeros and read as anything.

use core::fmt;
use core::marker::PhantomData;

use crate::descriptor::{MessageDescriptor, Shape};
use crate::error::{DecodeError, Fault};
use crate::layout::Size;
use crate::record::{FieldSink, FieldSource, Primitive, Record, Sink, Source, Value};
use crate::{Path, Text, UorbMessage};

/// The bytes that hold all fields of a message: the payload without the padding at its end.
pub fn payload<T: UorbMessage>(bytes: &[u8]) -> Result<&[u8], DecodeError> {
    if bytes.len() == T::SIZE || bytes.len() == T::SIZE_NO_PADDING {
        Ok(&bytes[..T::SIZE_NO_PADDING])
    } else {
        Err(wrong_size(T::DESCRIPTOR, Size { padded: T::SIZE, no_padding: T::SIZE_NO_PADDING }, bytes.len()))
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
    let mut reader = Reader::<STRICT> { bytes, base: 0, at: 0, failure: None };
    let message = T::read_fields(&mut reader);
    match reader.failure {
        None => Ok(message),
        Some(error) => Err(error),
    }
}

/// Writes a message to `bytes`, which are zeros, as many as its size.
#[inline]
pub(crate) fn encode<T: UorbMessage>(message: &T, bytes: &mut [u8]) {
    message.write_fields(&mut Writer { bytes, base: 0, at: 0 });
}

/// Reads a message from the bytes of its view.
#[inline]
pub fn read<T: Record>(bytes: &[u8]) -> T {
    T::read_fields(&mut Reader::<false> { bytes, base: 0, at: 0, failure: None })
}

/// The bytes of a message at `offset`, for its view; zeros where there are too few, which generated code
/// can't cause.
#[inline]
pub fn chunk<const N: usize>(bytes: &[u8], offset: usize) -> &[u8; N] {
    bytes.get(offset..).and_then(<[u8]>::first_chunk).unwrap_or(&[0; N])
}

/// Looks at the field `index` of a message.
#[inline]
pub fn look<M: Record, T: Viewed>(bytes: &[u8], index: usize) -> T::View<'_> {
    <T as Viewed>::view_at(bytes, M::DESCRIPTOR.fields[index].offset)
}

struct Reader<'b, const STRICT: bool> {
    bytes: &'b [u8],
    /// First byte of the message that is being read.
    base: usize,
    at: usize,
    failure: Option<DecodeError>,
}

impl<const STRICT: bool> Reader<'_, STRICT> {
    #[inline]
    fn take(&mut self, size: usize) -> &[u8] {
        let start = self.at;
        self.at += size;
        self.bytes.get(start..self.at).unwrap_or_default()
    }

    #[inline]
    fn refuse_odd_bool<P: Primitive>(&mut self, offset: usize) -> bool {
        if STRICT
            && self.failure.is_none()
            && let Some(byte) = self.bytes.get(offset..).and_then(P::odd_bool)
        {
            self.failure = Some(DecodeError { fault: Fault::Bool(byte), offset, path: Path::default() });
            return true;
        }
        false
    }
}

impl<const STRICT: bool> FieldSource for Reader<'_, STRICT> {
    #[inline]
    fn field<T: Value>(&mut self, message: &'static MessageDescriptor, index: usize) -> T {
        let field = &message.fields[index];
        self.at = self.base + field.offset;
        if !STRICT {
            return T::read(self, field);
        }
        let had_failed = self.has_failed();
        let value = T::read(self, field);
        if !had_failed && let Some(error) = &mut self.failure {
            error.path.enclose(message, index);
        }
        value
    }
}

impl<const STRICT: bool> Source for Reader<'_, STRICT> {
    #[inline]
    fn scalar<P: Primitive>(&mut self) -> P {
        self.refuse_odd_bool::<P>(self.at);
        P::read_le(self.take(P::SIZE))
    }

    #[inline]
    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        for index in 0..values.len() {
            if self.refuse_odd_bool::<P>(self.at + index * P::SIZE) {
                self.blame(index);
            }
        }
        let bytes = self.take(values.len() * P::SIZE);
        for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(P::SIZE)) {
            *value = P::read_le(bytes);
        }
    }

    fn length(&mut self, _: Shape, _: usize) -> usize {
        0 // messages of fixed size have no sequences
    }

    #[cfg(feature = "alloc")]
    fn string(&mut self, _: bool, _: Option<u32>) -> alloc::string::String {
        alloc::string::String::new() // nor strings
    }

    #[inline]
    fn message<M: Record>(&mut self) -> M {
        let (base, start) = (self.base, self.at);
        self.base = start;
        let message = M::read_fields(self);
        self.base = base;
        self.at = start + M::DESCRIPTOR.padded_size();
        message
    }

    #[inline]
    fn has_failed(&self) -> bool {
        STRICT && self.failure.is_some()
    }

    #[cold]
    fn blame(&mut self, element: usize) {
        if let Some(error) = &mut self.failure {
            error.path.within(element);
        }
    }
}

struct Writer<'b> {
    bytes: &'b mut [u8],
    /// First byte of the message that is being written.
    base: usize,
    at: usize,
}

impl Writer<'_> {
    #[inline]
    fn take(&mut self, size: usize) -> &mut [u8] {
        let start = self.at;
        self.at += size;
        self.bytes.get_mut(start..self.at).unwrap_or_default()
    }
}

impl FieldSink for Writer<'_> {
    #[inline]
    fn field<T: Value>(&mut self, message: &'static MessageDescriptor, index: usize, value: &T) {
        let field = &message.fields[index];
        self.at = self.base + field.offset;
        value.write(self, field);
    }
}

impl Sink for Writer<'_> {
    #[inline]
    fn scalar<P: Primitive>(&mut self, value: P) {
        value.write_le(self.take(P::SIZE));
    }

    #[inline]
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        let bytes = self.take(values.len() * P::SIZE);
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(P::SIZE)) {
            value.write_le(bytes);
        }
    }

    #[inline]
    fn text(&mut self, bytes: &[u8]) {
        self.scalars(bytes);
    }

    fn length(&mut self, _: usize, _: Shape) {}

    fn string(&mut self, _: &str, _: bool, _: Option<u32>) {}

    #[inline]
    fn message<M: Record>(&mut self, message: &M) {
        let (base, start) = (self.base, self.at);
        self.base = start;
        message.write_fields(self);
        self.base = base;
        self.at = start + M::DESCRIPTOR.padded_size();
    }

    #[inline]
    fn select(&mut self, _: Option<usize>) {}
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
