//! Reading and writing messages of fixed size, in any form.
//!
//! How many bytes there are is checked once, before: then no field can lack any, and as everything is
//! inlined, the compiler knows each offset. What remains are loads and stores, many values at a time.
#![allow(clippy::inline_always)] // a call in between, and the compiler knows no offset any more

use core::marker::PhantomData;
use core::mem;

use crate::Path;
use crate::descriptor::{MessageDescriptor, Shape};
use crate::error::{DecodeError, Fault};
use crate::record::{FieldSink, FieldSource, Primitive, Record, Sink, Source, Value};

/// A form that bytes have.
pub(crate) trait Form {
    /// Whether fields lie at the offsets of the memory layout; otherwise they follow one another.
    const HAS_OFFSETS: bool;

    /// Where a value of `size` bytes lies that comes after `at`.
    fn start(at: usize, size: usize) -> usize;

    /// The number that bytes hold.
    fn read<P: Primitive>(bytes: &[u8]) -> P;

    /// Writes a number.
    fn write<P: Primitive>(number: P, bytes: &mut [u8]);
}

/// Reads a message from bytes that suffice; in strict mode a `bool` other than 0 and 1 is a fault.
#[inline(always)]
pub(crate) fn read<T: Record, F: Form, const STRICT: bool>(
    bytes: &[u8],
    failure: &mut Option<DecodeError>,
) -> T {
    let mut reader = Reader::<F, STRICT> { message: T::DESCRIPTOR, bytes, at: 0, failure, form: PhantomData };
    if F::HAS_OFFSETS { T::read_fields(&mut reader) } else { reader.message() }
}

/// Writes a message to bytes that suffice and are zeros.
#[inline(always)]
pub(crate) fn write<T: Record, F: Form>(message: &T, bytes: &mut [u8]) {
    let mut writer = Writer::<F> { message: T::DESCRIPTOR, bytes, at: 0, form: PhantomData };
    if F::HAS_OFFSETS { message.write_fields(&mut writer) } else { writer.message(message) }
}

struct Reader<'b, F, const STRICT: bool> {
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    bytes: &'b [u8],
    at: usize,
    /// Apart, so that the compiler can keep the rest in registers.
    failure: &'b mut Option<DecodeError>,
    form: PhantomData<F>,
}

impl<'b, F: Form, const STRICT: bool> Reader<'b, F, STRICT> {
    /// The next `count` values of `size` bytes each.
    #[inline(always)]
    fn take(&mut self, size: usize, count: usize) -> &'b [u8] {
        let start = F::start(self.at, size);
        self.at = start + size * count;
        self.bytes.get(start..self.at).unwrap_or_default()
    }
}

#[cold]
fn refuse_bool(failure: &mut Option<DecodeError>, byte: u8, offset: usize, element: Option<usize>) {
    if failure.is_none() {
        let mut path = Path::default();
        if let Some(element) = element {
            path.within(element);
        }
        *failure = Some(DecodeError { fault: Fault::Bool(byte), offset, path });
    }
}

impl<F: Form, const STRICT: bool> FieldSource for Reader<'_, F, STRICT> {
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

impl<F: Form, const STRICT: bool> Source for Reader<'_, F, STRICT> {
    #[inline(always)]
    fn scalar<P: Primitive>(&mut self) -> P {
        let bytes = self.take(P::SIZE, 1);
        if STRICT && let Some(byte) = P::odd_bool(bytes) {
            refuse_bool(self.failure, byte, self.at - 1, None);
        }
        F::read(bytes)
    }

    #[inline(always)]
    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        let start = F::start(self.at, P::SIZE);
        let bytes = self.take(P::SIZE, values.len());
        for (index, (value, bytes)) in values.iter_mut().zip(bytes.chunks_exact(P::SIZE)).enumerate() {
            if STRICT && let Some(byte) = P::odd_bool(bytes) {
                refuse_bool(self.failure, byte, start + index, Some(index));
            }
            *value = F::read(bytes);
        }
    }

    fn length(&mut self, _: Shape, _: usize) -> usize {
        0 // messages of fixed size have no sequences
    }

    #[cfg(feature = "alloc")]
    fn string(&mut self, _: bool, _: Option<u32>) -> alloc::string::String {
        alloc::string::String::new() // nor strings
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
            form: PhantomData,
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
    fn blame(&mut self, element: usize) {
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
    form: PhantomData<F>,
}

impl<F: Form> Writer<'_, F> {
    /// Room for the next `count` values of `size` bytes each.
    #[inline(always)]
    fn take(&mut self, size: usize, count: usize) -> &mut [u8] {
        let start = F::start(self.at, size);
        self.at = start + size * count;
        self.bytes.get_mut(start..self.at).unwrap_or_default()
    }
}

impl<F: Form> FieldSink for Writer<'_, F> {
    #[inline(always)]
    fn field<T: Value>(&mut self, index: usize, value: &T) {
        let field = &self.message.fields[index];
        if F::HAS_OFFSETS {
            self.at = field.offset;
        }
        value.write(self, field);
    }
}

impl<F: Form> Sink for Writer<'_, F> {
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
                form: PhantomData,
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
