//! CDR, the encoding of messages in DDS and ROS 2: XCDR version 1, in both byte orders.
//!
//! A payload starts with a four-byte header that identifies the encoding. Alignment counts from the byte after the
//! header, and each number is aligned to its size. Sequences and strings start with their length as a `uint32`; the
//! length of a string includes its NUL. Arrays of fixed length have no length prefix. A message without fields takes
//! one byte.
//!
//! Wide strings are UTF-16 without a NUL, and their length counts code units. Each code unit is encoded as a
//! `uint32`, because ROS 2's `rosidl_typesupport_fastrtps` does so for compatibility with other DDS implementations.
//!
//! ```
//! use uavspec_runtime::cdr::{ByteOrder, HEADER};
//!
//! let payload = [ByteOrder::LittleEndian.header(), [42, 0, 0, 0]].concat();
//! assert_eq!(ByteOrder::of(&payload), Ok(ByteOrder::LittleEndian));
//! assert_eq!(payload[HEADER..], 42_u32.to_le_bytes());
//! ```

use core::mem;

use crate::descriptor::{Element, MessageDescriptor, Shape};
use crate::error::{DecodeError, EncodeError, Fault};
use crate::fixed::{self, Encoding};
use crate::record::{FieldSink, FieldSource, Primitive, Record, Sink, Source, Value};
use crate::{Message, Path};

/// Size of the header, in bytes.
pub const HEADER: usize = 4;

/// Size in bytes of one code unit in a wide string.
pub const WIDE_UNIT: usize = 4;

/// Byte order of the numbers in a payload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// Least significant byte first: the order that nearly all programs use.
    #[default]
    LittleEndian,
    /// Most significant byte first.
    BigEndian,
}

impl ByteOrder {
    /// The header of a payload in this byte order.
    pub const fn header(self) -> [u8; HEADER] {
        match self {
            Self::LittleEndian => [0, 1, 0, 0],
            Self::BigEndian => [0, 0, 0, 0],
        }
    }

    /// The byte order named in a payload's header.
    pub fn of(payload: &[u8]) -> Result<Self, Fault> {
        match *payload {
            [0, 1, _, _, ..] => Ok(Self::LittleEndian),
            [0, 0, _, _, ..] => Ok(Self::BigEndian),
            [first, second, _, _, ..] => Err(Fault::Encapsulation([first, second])),
            _ => Err(Fault::Truncated { needed: HEADER, left: payload.len() }),
        }
    }
}

/// True if the remaining `left` bytes, after a message that ends at `end`, can be padding. Transports pad payloads to a
/// multiple of four bytes.
pub const fn is_padding(end: usize, left: usize) -> bool {
    end + left <= end.next_multiple_of(4)
}

/// The code units of a wide string, with an error for each unit of more than 16 bits.
pub fn wide_units(bytes: &[u8], order: ByteOrder) -> impl Iterator<Item = Result<u16, Fault>> {
    let unit = move |bytes: &[u8]| {
        let unit = match order {
            ByteOrder::LittleEndian => u32::read_le(bytes),
            ByteOrder::BigEndian => u32::read_be(bytes),
        };
        u16::try_from(unit).map_err(|_| Fault::NotUnicode)
    };
    bytes.chunks_exact(WIDE_UNIT).map(unit)
}

/// Decodes a message. In strict mode each `bool` must be 0 or 1.
#[inline]
pub(crate) fn decode<T: Message, const STRICT: bool>(payload: &[u8]) -> Result<T, DecodeError> {
    match ByteOrder::of(payload) {
        Ok(ByteOrder::LittleEndian) => decode_body::<T, false, STRICT>(payload),
        Ok(ByteOrder::BigEndian) => decode_body::<T, true, STRICT>(payload),
        Err(fault) => Err(DecodeError { fault, offset: 0, path: Path::to(T::DESCRIPTOR) }),
    }
}

fn decode_body<T: Message, const BIG: bool, const STRICT: bool>(payload: &[u8]) -> Result<T, DecodeError> {
    let mut failure = None;
    if let Some(size) = T::CDR_SIZE {
        let Some(body) = payload.get(HEADER..size) else {
            return Err(truncated(T::DESCRIPTOR, payload.len()));
        };
        let message = fixed::read::<T, Packed<BIG>, STRICT>(body, &mut failure);
        if let Some(error) = &mut failure {
            error.offset += HEADER;
        }
        return finish(T::DESCRIPTOR, message, size, payload.len() - size, failure);
    }
    let body = payload.get(HEADER..).unwrap_or_default();
    let mut reader = Reader::<BIG, STRICT> { message: T::DESCRIPTOR, body, at: 0, failure: &mut failure };
    let message = reader.message();
    let end = reader.at;
    finish(T::DESCRIPTOR, message, end + HEADER, body.len().saturating_sub(end), failure)
}

/// The encoding of fixed-size messages, which needs no length prefixes.
struct Packed<const BIG: bool>;

impl<const BIG: bool> Encoding for Packed<BIG> {
    const HAS_OFFSETS: bool = false;

    #[inline]
    fn start(at: usize, size: usize) -> usize {
        at.next_multiple_of(size)
    }

    #[inline]
    fn read<P: Primitive>(bytes: &[u8]) -> P {
        if BIG { P::read_be(bytes) } else { P::read_le(bytes) }
    }

    #[inline]
    fn write<P: Primitive>(number: P, bytes: &mut [u8]) {
        if BIG { number.write_be(bytes) } else { number.write_le(bytes) }
    }
}

/// The error for a payload that is too short for its fixed-size message.
#[cold]
fn truncated(message: &'static MessageDescriptor, size: usize) -> DecodeError {
    let mut path = Path::default();
    let (fault, offset) = find_end(message, &mut 0, size - HEADER, &mut path)
        .unwrap_or((Fault::Truncated { needed: 1, left: 0 }, size - HEADER));
    if path == Path::default() {
        path = Path::to(message);
    }
    DecodeError { fault, offset: offset + HEADER, path }
}

/// Finds the first value that doesn't end within the first `end` bytes, and its offset. Advances `at` past all earlier
/// values.
fn find_end(
    message: &'static MessageDescriptor,
    at: &mut usize,
    end: usize,
    path: &mut Path,
) -> Option<(Fault, usize)> {
    if message.fields.is_empty() {
        // A message without fields takes one byte.
        *at += 1;
        return (*at > end).then_some((Fault::Truncated { needed: 1, left: 0 }, end));
    }
    for (index, field) in message.fields.iter().enumerate() {
        let count = if let Shape::Array(length) = field.shape { length as usize } else { 1 };
        let found = match field.element {
            Element::Message(nested) => (0..count).find_map(|element| {
                let found = find_end(nested, at, end, path)?;
                if field.shape != Shape::Single {
                    path.within(element);
                }
                Some(found)
            }),
            Element::Scalar(_) | Element::Text | Element::String { .. } => {
                let size = if let Element::Scalar(scalar) = field.element { scalar.size() } else { 1 };
                let start = at.next_multiple_of(size);
                *at = start + size * count;
                (*at > end).then(|| {
                    let left = end.saturating_sub(start);
                    if field.shape != Shape::Single {
                        path.within(left / size);
                    }
                    (Fault::Truncated { needed: size * count, left }, start.min(end))
                })
            }
        };
        if found.is_some() {
            path.enclose(message, index);
            return found;
        }
    }
    None
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
        None if left == 0 || is_padding(end, left) => Ok(message),
        None => Err(DecodeError { fault: Fault::Trailing(left), offset: end, path: Path::to(descriptor) }),
    }
}

struct Reader<'b, const BIG: bool, const STRICT: bool> {
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    /// The bytes after the header.
    body: &'b [u8],
    at: usize,
    /// Stored as a reference, so the compiler can keep the other fields in registers.
    failure: &'b mut Option<DecodeError>,
}

#[cold]
fn fail(failure: &mut Option<DecodeError>, fault: Fault, offset: usize) {
    if failure.is_none() {
        *failure = Some(DecodeError { fault, offset: offset + HEADER, path: Path::default() });
    }
}

impl<'b, const BIG: bool, const STRICT: bool> Reader<'b, BIG, STRICT> {
    /// The next `size` bytes, after alignment.
    #[inline]
    fn take(&mut self, size: usize, alignment: usize) -> &'b [u8] {
        let start = self.at.next_multiple_of(alignment);
        // The addition overflows only if the payload is too short anyway.
        if let Some(bytes) = start.checked_add(size).and_then(|end| self.body.get(start..end)) {
            self.at = start + size;
            return bytes;
        }
        let left = self.body.len().saturating_sub(start);
        self.fail(Fault::Truncated { needed: size, left }, start.min(self.body.len()));
        &[]
    }

    #[inline]
    fn fail(&mut self, fault: Fault, offset: usize) {
        fail(self.failure, fault, offset);
        // All later reads find no bytes.
        self.at = self.body.len();
    }
}

impl<const BIG: bool, const STRICT: bool> FieldSource for Reader<'_, BIG, STRICT> {
    #[inline]
    fn field<T: Value>(&mut self, index: usize) -> T {
        let had_failed = self.has_failed();
        let value = T::read(self, &self.message.fields[index]);
        if !had_failed && let Some(error) = self.failure {
            error.path.enclose(self.message, index);
        }
        value
    }
}

impl<const BIG: bool, const STRICT: bool> Source for Reader<'_, BIG, STRICT> {
    #[inline]
    fn scalar<P: Primitive>(&mut self) -> P {
        let bytes = self.take(P::SIZE, P::SIZE);
        if STRICT && let Some(byte) = P::invalid_bool(bytes) {
            self.fail(Fault::Bool(byte), self.at - 1);
        }
        Packed::<BIG>::read(bytes)
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
            self.locate_fault(left / P::SIZE);
        }
        if STRICT {
            for (index, byte) in bytes.chunks_exact(P::SIZE).enumerate() {
                if !self.has_failed()
                    && let Some(byte) = P::invalid_bool(byte)
                {
                    self.fail(Fault::Bool(byte), start + index);
                    self.locate_fault(index);
                }
            }
        }
        for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(P::SIZE)) {
            *value = Packed::<BIG>::read(bytes);
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
        let length = self.length(Shape::Sequence, if is_wide { WIDE_UNIT } else { 1 });
        let text = if is_wide {
            let order = if BIG { ByteOrder::BigEndian } else { ByteOrder::LittleEndian };
            let units = wide_units(self.take(length * WIDE_UNIT, 1), order);
            let units: Result<alloc::vec::Vec<u16>, Fault> = units.collect();
            units.and_then(|units| alloc::string::String::from_utf16(&units).map_err(|_| Fault::NotUnicode))
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
        let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
        let message = M::read_fields(self);
        self.message = outer;
        message
    }

    #[inline]
    fn has_failed(&self) -> bool {
        self.failure.is_some()
    }

    #[inline]
    fn locate_fault(&mut self, element: usize) {
        if let Some(error) = self.failure {
            error.path.within(element);
        }
    }
}

#[cfg(feature = "alloc")]
impl<const BIG: bool, const STRICT: bool> Reader<'_, BIG, STRICT> {
    /// Reads a string of `length` bytes, including its NUL. Some writers omit the NUL of an empty string.
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

/// True if `text` has more than `bound` characters.
fn exceeds(text: &str, bound: u32) -> bool {
    let bound = bound as usize;
    text.len() > bound && text.chars().count() > bound
}

/// Writes a message with its header to the start of `buffer` and returns its size in bytes.
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
    if let Some(size) = T::CDR_SIZE {
        let Some(body) = buffer.get_mut(HEADER..size) else { return Err(too_small(size)) };
        // Padding between values is zero.
        body.fill(0);
        match order {
            ByteOrder::LittleEndian => fixed::write::<T, Packed<false>>(message, body),
            ByteOrder::BigEndian => fixed::write::<T, Packed<true>>(message, body),
        }
        return Ok(size);
    }
    let body = &mut buffer[HEADER..];
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
    let mut failure = None;
    let mut writer =
        Writer::<BIG> { message: T::DESCRIPTOR, body, at: 0, failure: &mut failure, element: None };
    writer.message(message);
    (writer.at, failure)
}

/// Size of an encoded message with its header, in bytes.
#[cfg(feature = "alloc")]
pub(crate) fn size<T: Message>(message: &T) -> usize {
    // The writer counts bytes that don't fit, but doesn't write them.
    T::CDR_SIZE.unwrap_or_else(|| write_body::<T, false>(message, &mut []).0 + HEADER)
}

struct Writer<'b, const BIG: bool> {
    /// The message whose fields are written.
    message: &'static MessageDescriptor,
    body: &'b mut [u8],
    at: usize,
    /// Stored as a reference, so the compiler can keep the other fields in registers.
    failure: &'b mut Option<EncodeError>,
    /// Index of the array element that is being written.
    element: Option<usize>,
}

impl<const BIG: bool> Writer<'_, BIG> {
    /// Room for the next `size` bytes, after alignment. Empty if the buffer is too small.
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
            *self.failure = Some(EncodeError { fault, path });
        }
    }
}

impl<const BIG: bool> FieldSink for Writer<'_, BIG> {
    #[inline]
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        let had_failed = self.failure.is_some();
        value.write(self, &self.message.fields[index]);
        if !had_failed && let Some(error) = self.failure {
            error.path.enclose(self.message, index);
        }
    }
}

impl<const BIG: bool> Sink for Writer<'_, BIG> {
    #[inline]
    fn scalar<P: Primitive>(&mut self, value: P) {
        let bytes = self.take(P::SIZE, P::SIZE);
        if !bytes.is_empty() {
            Packed::<BIG>::write(value, bytes);
        }
    }

    #[inline]
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        if values.is_empty() {
            return;
        }
        let bytes = self.take(values.len() * P::SIZE, P::SIZE);
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(P::SIZE)) {
            Packed::<BIG>::write(*value, bytes);
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
                self.scalar(u32::from(unit));
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
        let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
        message.write_fields(self);
        self.message = outer;
        if !had_failed && let (Some(error), Some(element)) = (self.failure.as_mut(), element) {
            error.path.within(element);
        }
    }

    #[inline]
    fn select(&mut self, element: Option<usize>) {
        self.element = element;
    }
}
