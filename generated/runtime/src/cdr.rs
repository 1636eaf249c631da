//! CDR, the form in which DDS and ROS 2 carry messages: XCDR version 1, in both byte orders.
//!
//! A payload starts with four bytes that name the encoding; alignment counts from the byte after
//! them, and each number is aligned to its size. Arrays of fixed length stand for themselves,
//! sequences and strings after a `uint32` length, which for a string counts its NUL. A message
//! without fields takes one byte. Wide strings are UTF-16 without a NUL, their length in code units.

use crate::descriptor::{MessageDescriptor, Shape};
use crate::error::{DecodeError, EncodeError, Fault};
use crate::record::{FieldSink, FieldSource, Primitive, Record, Sink, Source, Value};
use crate::{Message, Path};

/// Bytes before the first member.
pub const HEADER: usize = 4;

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// Least significant byte first: what nearly everything sends.
    #[default]
    LittleEndian,
    /// Most significant byte first.
    BigEndian,
}

impl ByteOrder {
    /// The four bytes that a payload in this order starts with.
    pub const fn header(self) -> [u8; HEADER] {
        match self {
            Self::LittleEndian => [0, 1, 0, 0],
            Self::BigEndian => [0, 0, 0, 0],
        }
    }

    /// The order of a payload, told by how it starts.
    pub fn of(payload: &[u8]) -> Result<Self, Fault> {
        match *payload {
            [0, 1, _, _, ..] => Ok(Self::LittleEndian),
            [0, 0, _, _, ..] => Ok(Self::BigEndian),
            [first, second, _, _, ..] => Err(Fault::Encapsulation([first, second])),
            _ => Err(Fault::Truncated { needed: HEADER, left: payload.len() }),
        }
    }
}

/// Whether as many bytes may follow a message that ends at `end`: transports fill up to multiples of 4.
pub const fn is_filling(end: usize, left: usize) -> bool {
    end + left <= end.next_multiple_of(4)
}

/// Reads a message; in strict mode each `bool` must be 0 or 1.
#[inline]
pub(crate) fn decode<T: Message, const STRICT: bool>(payload: &[u8]) -> Result<T, DecodeError> {
    let order = ByteOrder::of(payload);
    let order = order.map_err(|fault| DecodeError { fault, offset: 0, path: Path::to(T::DESCRIPTOR) })?;
    match order {
        ByteOrder::LittleEndian => decode_body::<T, false, STRICT>(payload),
        ByteOrder::BigEndian => decode_body::<T, true, STRICT>(payload),
    }
}

fn decode_body<T: Message, const BIG: bool, const STRICT: bool>(payload: &[u8]) -> Result<T, DecodeError> {
    // Of a message of fixed size, the compiler then knows each offset, and that there are enough bytes.
    if let Some(size) = T::CDR_SIZE
        && let Some(body) = payload.get(HEADER..size)
    {
        let mut reader = Reader::<BIG, STRICT> { body, at: 0, failure: None };
        let message = T::read_fields(&mut reader);
        return finish(T::DESCRIPTOR, message, size, payload.len() - size, reader.failure);
    }
    let body = payload.get(HEADER..).unwrap_or_default();
    let mut reader = Reader::<BIG, STRICT> { body, at: 0, failure: None };
    let message = reader.message();
    let left = body.len().saturating_sub(reader.at);
    finish(T::DESCRIPTOR, message, reader.at + HEADER, left, reader.failure)
}

#[inline]
fn finish<T>(
    descriptor: &'static MessageDescriptor,
    message: T,
    end: usize,
    left: usize,
    failure: Option<DecodeError>,
) -> Result<T, DecodeError> {
    match failure {
        Some(error) => Err(error),
        None if left == 0 || is_filling(end, left) => Ok(message),
        None => Err(DecodeError { fault: Fault::Trailing(left), offset: end, path: Path::to(descriptor) }),
    }
}

struct Reader<'b, const BIG: bool, const STRICT: bool> {
    /// What follows the header.
    body: &'b [u8],
    at: usize,
    failure: Option<DecodeError>,
}

impl<'b, const BIG: bool, const STRICT: bool> Reader<'b, BIG, STRICT> {
    /// The next `size` bytes, aligned.
    #[inline]
    fn take(&mut self, size: usize, alignment: usize) -> &'b [u8] {
        let start = self.at.next_multiple_of(alignment);
        // The end may overflow only where there are not as many bytes.
        if let Some(bytes) = start.checked_add(size).and_then(|end| self.body.get(start..end)) {
            self.at = start + size;
            return bytes;
        }
        let left = self.body.len().saturating_sub(start);
        self.fail(Fault::Truncated { needed: size, left }, start.min(self.body.len()));
        &[]
    }

    #[cold]
    fn fail(&mut self, fault: Fault, offset: usize) {
        if self.failure.is_none() {
            let path = Path::default();
            self.failure = Some(DecodeError { fault, offset: offset + HEADER, path });
        }
        // Nothing is read from here on.
        self.at = self.body.len();
    }

    #[inline]
    fn number<P: Primitive>(bytes: &[u8]) -> P {
        if BIG { P::read_be(bytes) } else { P::read_le(bytes) }
    }
}

impl<const BIG: bool, const STRICT: bool> FieldSource for Reader<'_, BIG, STRICT> {
    #[inline]
    fn field<T: Value>(&mut self, message: &'static MessageDescriptor, index: usize) -> T {
        let had_failed = self.has_failed();
        let value = T::read(self, &message.fields[index]);
        if !had_failed && let Some(error) = &mut self.failure {
            error.path.enclose(message, index);
        }
        value
    }
}

impl<const BIG: bool, const STRICT: bool> Source for Reader<'_, BIG, STRICT> {
    #[inline]
    fn scalar<P: Primitive>(&mut self) -> P {
        let bytes = self.take(P::SIZE, P::SIZE);
        if STRICT && let Some(byte) = P::odd_bool(bytes) {
            self.fail(Fault::Bool(byte), self.at - 1);
        }
        Self::number(bytes)
    }

    #[inline]
    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        if values.is_empty() {
            return;
        }
        let had_failed = self.has_failed();
        let start = self.at;
        let bytes = self.take(values.len().saturating_mul(P::SIZE), P::SIZE);
        if !had_failed && self.has_failed() {
            let left = self.body.len().saturating_sub(start.next_multiple_of(P::SIZE));
            self.blame(left / P::SIZE);
        }
        if STRICT {
            for (index, byte) in bytes.chunks_exact(P::SIZE).enumerate() {
                if !self.has_failed()
                    && let Some(byte) = P::odd_bool(byte)
                {
                    self.fail(Fault::Bool(byte), start + index);
                    self.blame(index);
                }
            }
        }
        for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(P::SIZE)) {
            *value = Self::number(bytes);
        }
    }

    #[inline]
    fn length(&mut self, shape: Shape, element_size: usize) -> usize {
        let length: u32 = self.scalar();
        let found = usize::try_from(length).unwrap_or(usize::MAX);
        if let Some(bound) = shape.bound().filter(|bound| length > *bound) {
            self.fail(Fault::TooLong { bound, found }, self.at.saturating_sub(4));
            return 0;
        }
        let left = self.body.len() - self.at;
        let needed = found.saturating_mul(element_size);
        if needed > left {
            self.fail(Fault::Truncated { needed, left }, self.at);
            return 0;
        }
        found
    }

    #[cfg(feature = "alloc")]
    fn string(&mut self, is_wide: bool, bound: Option<u32>) -> alloc::string::String {
        let start = self.at;
        let length = self.length(Shape::Sequence, if is_wide { 2 } else { 1 });
        let text = if is_wide {
            let bytes = self.take(length * 2, 1);
            let units = bytes.chunks_exact(2).map(Self::number::<u16>);
            char::decode_utf16(units).collect::<Result<_, _>>().map_err(|_| Fault::NotUnicode)
        } else {
            self.narrow_string(length)
        };
        let text = text.and_then(|text: alloc::string::String| match bound {
            Some(bound) if exceeds(&text, bound) => {
                Err(Fault::TooLong { bound, found: text.chars().count() })
            }
            _ => Ok(text),
        });
        text.unwrap_or_else(|fault| {
            self.fail(fault, start.next_multiple_of(4));
            alloc::string::String::new()
        })
    }

    #[inline]
    fn message<M: Record>(&mut self) -> M {
        if M::DESCRIPTOR.fields.is_empty() {
            self.take(1, 1);
        }
        M::read_fields(self)
    }

    #[inline]
    fn has_failed(&self) -> bool {
        self.failure.is_some()
    }

    #[cold]
    fn blame(&mut self, element: usize) {
        if let Some(error) = &mut self.failure {
            error.path.within(element);
        }
    }
}

#[cfg(feature = "alloc")]
impl<const BIG: bool, const STRICT: bool> Reader<'_, BIG, STRICT> {
    /// A string of as many bytes, its NUL among them. Some writers send an empty string without one.
    fn narrow_string(&mut self, length: usize) -> Result<alloc::string::String, Fault> {
        let bytes = self.take(length, 1);
        let text = match bytes.split_last() {
            None => return Ok(alloc::string::String::new()),
            Some((0, text)) if !text.contains(&0) => text,
            Some(_) => return Err(Fault::Nul),
        };
        core::str::from_utf8(text).map(Into::into).map_err(|_| Fault::NotUnicode)
    }
}

/// Whether `text` has more than `bound` characters.
fn exceeds(text: &str, bound: u32) -> bool {
    let bound = bound as usize;
    text.len() > bound && text.chars().count() > bound
}

/// Writes a message with its header to the start of `buffer` and returns how many bytes it takes.
pub(crate) fn encode<T: Message>(
    message: &T,
    order: ByteOrder,
    buffer: &mut [u8],
) -> Result<usize, EncodeError> {
    let room = buffer.len();
    let too_small =
        |needed| EncodeError { fault: Fault::Buffer { needed, room }, path: Path::to(T::DESCRIPTOR) };
    let Some(header) = buffer.first_chunk_mut() else { return Err(too_small(HEADER)) };
    *header = order.header();
    let body = match T::CDR_SIZE {
        // As with reading: the compiler then knows each offset.
        Some(size) => buffer.get_mut(HEADER..size).ok_or(too_small(size))?,
        None => &mut buffer[HEADER..],
    };
    let (at, failure) = match order {
        ByteOrder::LittleEndian => write_body::<T, false>(message, body),
        ByteOrder::BigEndian => write_body::<T, true>(message, body),
    };
    match failure {
        Some(error) => Err(error),
        None if at + HEADER > room => Err(too_small(at + HEADER)),
        None => Ok(at + HEADER),
    }
}

fn write_body<T: Record, const BIG: bool>(message: &T, body: &mut [u8]) -> (usize, Option<EncodeError>) {
    let mut writer = Writer::<BIG> { body, at: 0, failure: None, element: None };
    writer.message(message);
    (writer.at, writer.failure)
}

/// How many bytes a message takes, header and all.
#[cfg(feature = "alloc")]
pub(crate) fn size<T: Message>(message: &T) -> usize {
    // What doesn't fit is counted and not written.
    T::CDR_SIZE.unwrap_or_else(|| write_body::<T, false>(message, &mut []).0 + HEADER)
}

struct Writer<'b, const BIG: bool> {
    body: &'b mut [u8],
    at: usize,
    failure: Option<EncodeError>,
    /// The element that is being written.
    element: Option<usize>,
}

impl<const BIG: bool> Writer<'_, BIG> {
    /// Room for the next `size` bytes, aligned; none where the buffer ends.
    #[inline]
    fn take(&mut self, size: usize, alignment: usize) -> &mut [u8] {
        let start = self.at.next_multiple_of(alignment);
        if let Some(gap) = self.body.get_mut(self.at..start) {
            gap.fill(0);
        }
        self.at = start + size;
        self.body.get_mut(start..self.at).unwrap_or_default()
    }

    #[cold]
    fn fail(&mut self, fault: Fault) {
        if self.failure.is_none() {
            let mut path = Path::default();
            if let Some(element) = self.element {
                path.within(element);
            }
            self.failure = Some(EncodeError { fault, path });
        }
    }
}

impl<const BIG: bool> FieldSink for Writer<'_, BIG> {
    #[inline]
    fn field<T: Value>(&mut self, message: &'static MessageDescriptor, index: usize, value: &T) {
        let had_failed = self.failure.is_some();
        value.write(self, &message.fields[index]);
        if !had_failed && let Some(error) = &mut self.failure {
            error.path.enclose(message, index);
        }
    }
}

impl<const BIG: bool> Sink for Writer<'_, BIG> {
    #[inline]
    fn scalar<P: Primitive>(&mut self, value: P) {
        let bytes = self.take(P::SIZE, P::SIZE);
        if !bytes.is_empty() {
            if BIG { value.write_be(bytes) } else { value.write_le(bytes) }
        }
    }

    #[inline]
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        if values.is_empty() {
            return;
        }
        let bytes = self.take(values.len() * P::SIZE, P::SIZE);
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(P::SIZE)) {
            if BIG { value.write_be(bytes) } else { value.write_le(bytes) }
        }
    }

    #[inline]
    fn text(&mut self, bytes: &[u8]) {
        self.scalars(bytes);
    }

    #[inline]
    fn length(&mut self, length: usize, shape: Shape) {
        let bound = shape.bound().unwrap_or(u32::MAX);
        match u32::try_from(length).ok().filter(|length| *length <= bound) {
            Some(length) => self.scalar(length),
            None => self.fail(Fault::TooLong { bound, found: length }),
        }
    }

    fn string(&mut self, text: &str, is_wide: bool, bound: Option<u32>) {
        if let Some(bound) = bound.filter(|bound| exceeds(text, *bound)) {
            return self.fail(Fault::TooLong { bound, found: text.chars().count() });
        }
        if is_wide {
            self.length(text.encode_utf16().count(), Shape::Sequence);
            for unit in text.encode_utf16() {
                self.scalar(unit);
            }
        } else if text.as_bytes().contains(&0) {
            self.fail(Fault::Nul);
        } else {
            self.length(text.len() + 1, Shape::Sequence);
            self.scalars(text.as_bytes());
            self.scalar(0_u8);
        }
    }

    #[inline]
    fn message<M: Record>(&mut self, message: &M) {
        let had_failed = self.failure.is_some();
        let element = self.element.take();
        if M::DESCRIPTOR.fields.is_empty() {
            self.scalar(0_u8);
        }
        message.write_fields(self);
        if !had_failed && let (Some(error), Some(element)) = (&mut self.failure, element) {
            error.path.within(element);
        }
    }

    #[inline]
    fn select(&mut self, element: Option<usize>) {
        self.element = element;
    }
}
