//! Codec for fixed-size messages, generic over the encoding.
//!
//! The caller checks the number of bytes once, so no field can be truncated. Everything is inlined, so the compiler
//! knows each offset and can load or store several values in one instruction.
#![allow(clippy::inline_always)] // otherwise the compiler doesn't know the offsets

use core::marker::PhantomData;
use core::mem;

use crate::Path;
use crate::descriptor::{MessageDescriptor, Shape};
use crate::error::{DecodeError, Fault};
use crate::record::{FieldSink, FieldSource, Primitive, Record, Sink, Source, Value};

/// An encoding of fixed-size messages.
pub(crate) trait Encoding {
    /// True if fields are at the offsets of the memory layout; false if each field follows the previous field.
    const HAS_OFFSETS: bool;

    /// The offset of a value of `size` bytes, if the previous value ends at `at`.
    fn start(at: usize, size: usize) -> usize;

    /// Reads a number.
    fn read<P: Primitive>(bytes: &[u8]) -> P;

    /// Writes a number.
    fn write<P: Primitive>(number: P, bytes: &mut [u8]);
}

/// Reads a message. `bytes` must be long enough. In strict mode, a `bool` other than 0 or 1 is a fault.
#[inline(always)]
pub(crate) fn read<T: Record, F: Encoding, const STRICT: bool>(
    bytes: &[u8],
    failure: &mut Option<DecodeError>,
) -> T {
    let mut reader =
        Reader::<F, STRICT> { message: T::DESCRIPTOR, bytes, at: 0, failure, encoding: PhantomData };
    if F::HAS_OFFSETS { T::read_fields(&mut reader) } else { reader.message() }
}

/// Writes a message. `bytes` must be long enough and all zeros.
#[inline(always)]
pub(crate) fn write<T: Record, F: Encoding>(message: &T, bytes: &mut [u8]) {
    let mut writer = Writer::<F> { message: T::DESCRIPTOR, bytes, at: 0, encoding: PhantomData };
    if F::HAS_OFFSETS { message.write_fields(&mut writer) } else { writer.message(message) }
}

struct Reader<'b, F, const STRICT: bool> {
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    bytes: &'b [u8],
    at: usize,
    /// Stored as a reference, so the compiler can keep the other fields in registers.
    failure: &'b mut Option<DecodeError>,
    encoding: PhantomData<F>,
}

impl<'b, F: Encoding, const STRICT: bool> Reader<'b, F, STRICT> {
    /// The next `count` values of `size` bytes each.
    #[inline(always)]
    fn take(&mut self, size: usize, count: usize) -> &'b [u8] {
        let start = F::start(self.at, size);
        self.at = start + size * count;
        self.bytes.get(start..self.at).unwrap_or_default()
    }
}

#[cold]
fn record_bool_fault(failure: &mut Option<DecodeError>, byte: u8, offset: usize, element: Option<usize>) {
    if failure.is_none() {
        let mut path = Path::default();
        if let Some(element) = element {
            path.within(element);
        }
        *failure = Some(DecodeError { fault: Fault::Bool(byte), offset, path });
    }
}

impl<F: Encoding, const STRICT: bool> FieldSource for Reader<'_, F, STRICT> {
    #[inline(always)]
    fn field<T: Value>(&mut self, index: usize) -> T {
        let field = &self.message.fields[index];
        if F::HAS_OFFSETS {
            self.at = field.offset;
        }
        let had_failed = self.has_failed();
        let value = T::read(self, field);
        if STRICT
            && !had_failed
            && let Some(error) = self.failure
        {
            error.path.enclose(self.message, index);
        }
        value
    }
}

impl<F: Encoding, const STRICT: bool> Source for Reader<'_, F, STRICT> {
    #[inline(always)]
    fn scalar<P: Primitive>(&mut self) -> P {
        let bytes = self.take(P::SIZE, 1);
        if STRICT && let Some(byte) = P::invalid_bool(bytes) {
            record_bool_fault(self.failure, byte, self.at - 1, None);
        }
        F::read(bytes)
    }

    #[inline(always)]
    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        let start = F::start(self.at, P::SIZE);
        let bytes = self.take(P::SIZE, values.len());
        for (index, (value, bytes)) in values.iter_mut().zip(bytes.chunks_exact(P::SIZE)).enumerate() {
            if STRICT && let Some(byte) = P::invalid_bool(bytes) {
                record_bool_fault(self.failure, byte, start + index, Some(index));
            }
            *value = F::read(bytes);
        }
    }

    fn length(&mut self, _: Shape, _: usize) -> usize {
        0 // fixed-size messages have no sequences
    }

    #[cfg(feature = "alloc")]
    fn string(&mut self, _: bool, _: Option<u32>) -> alloc::string::String {
        alloc::string::String::new() // fixed-size messages have no strings
    }

    #[inline(always)]
    fn message<M: Record>(&mut self) -> M {
        if !F::HAS_OFFSETS {
            if M::DESCRIPTOR.fields.is_empty() {
                self.at += 1;
            }
            let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
            let message = M::read_fields(self);
            self.message = outer;
            return message;
        }
        let start = self.at;
        let bytes = self.take(1, M::DESCRIPTOR.padded_size());
        let had_failed = self.has_failed();
        let mut nested = Reader::<F, STRICT> {
            message: M::DESCRIPTOR,
            bytes,
            at: 0,
            failure: self.failure,
            encoding: PhantomData,
        };
        let message = M::read_fields(&mut nested);
        if STRICT
            && !had_failed
            && let Some(error) = self.failure
        {
            error.offset += start;
        }
        message
    }

    #[inline(always)]
    fn has_failed(&self) -> bool {
        STRICT && self.failure.is_some()
    }

    #[inline(always)]
    fn locate_fault(&mut self, element: usize) {
        if STRICT && let Some(error) = self.failure {
            error.path.within(element);
        }
    }
}

struct Writer<'b, F> {
    /// The message whose fields are written.
    message: &'static MessageDescriptor,
    bytes: &'b mut [u8],
    at: usize,
    encoding: PhantomData<F>,
}

impl<F: Encoding> Writer<'_, F> {
    /// Room for the next `count` values of `size` bytes each.
    #[inline(always)]
    fn take(&mut self, size: usize, count: usize) -> &mut [u8] {
        let start = F::start(self.at, size);
        self.at = start + size * count;
        self.bytes.get_mut(start..self.at).unwrap_or_default()
    }
}

impl<F: Encoding> FieldSink for Writer<'_, F> {
    #[inline(always)]
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        let field = &self.message.fields[index];
        if F::HAS_OFFSETS {
            self.at = field.offset;
        }
        value.write(self, field);
    }
}

impl<F: Encoding> Sink for Writer<'_, F> {
    #[inline(always)]
    fn scalar<P: Primitive>(&mut self, value: P) {
        F::write(value, self.take(P::SIZE, 1));
    }

    #[inline(always)]
    fn scalars<P: Primitive>(&mut self, values: &[P]) {
        let bytes = self.take(P::SIZE, values.len());
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(P::SIZE)) {
            F::write(*value, bytes);
        }
    }

    #[inline(always)]
    fn text(&mut self, bytes: &[u8]) {
        self.scalars(bytes);
    }

    fn length(&mut self, _: usize, _: Shape) {}

    fn string(&mut self, _: &str, _: bool, _: Option<u32>) {}

    #[inline(always)]
    fn message<M: Record>(&mut self, message: &M) {
        if F::HAS_OFFSETS {
            let bytes = self.take(1, M::DESCRIPTOR.padded_size());
            message.write_fields(&mut Writer::<F> {
                message: M::DESCRIPTOR,
                bytes,
                at: 0,
                encoding: PhantomData,
            });
        } else {
            if M::DESCRIPTOR.fields.is_empty() {
                self.at += 1;
            }
            let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
            message.write_fields(self);
            self.message = outer;
        }
    }

    #[inline(always)]
    fn select(&mut self, _: Option<usize>) {}
}
