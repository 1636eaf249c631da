//! Converts messages in memory. A conversion is compiled once; most of its operations then copy several fields together.

mod compile;
mod lost;
mod number;
mod place;

use std::fmt;

use uavspec_runtime::Scalar;

use self::lost::Test;
use self::number::{Number, read, write};
use self::place::{Place, Room};
use super::expression::Expression;
use super::plan::Conversion;
use crate::limits::MAX_CONVERTED;
use crate::{DynamicMessage, MessageType, SLOT, part, sequence};

/// A conversion, compiled for the types of the source and the target.
#[derive(Debug)]
pub struct Converter<'t> {
    target: MessageType<'t>,
    program: Program,
    keeps_cdr: bool,
    /// One test for each loss of the conversion.
    tests: Vec<Option<Test>>,
}

/// The converted message would be larger than [`MAX_CONVERTED`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

impl fmt::Display for TooLarge {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "the converted message takes more than {} MiB", MAX_CONVERTED >> 20)
    }
}

impl std::error::Error for TooLarge {}

/// The operations that fill a message of the target.
#[derive(Debug)]
struct Program {
    /// The initial message. Strings and sequences with a default follow the fields.
    initial: Vec<u8>,
    /// The size of the fields.
    size: usize,
    operations: Vec<Operation>,
    /// The strings and sequences of the initial message.
    defaults: Vec<usize>,
}

#[derive(Debug)]
enum Operation {
    /// Copies contiguous bytes.
    Copy(Span),
    Transfer(Box<Transfer>),
    Compute(Box<Compute>),
    /// Empties a sequence.
    Clear(usize),
}

/// Bytes that are contiguous in the source and in the target.
#[derive(Clone, Copy, Debug)]
struct Span {
    from: usize,
    to: usize,
    size: usize,
}

/// Converts the elements of a field. A single field is an array with one element.
#[derive(Debug)]
struct Transfer {
    from: Place,
    to: Place,
    element: ElementCopy,
    /// The value of elements that the source lacks; `None` keeps the initial value.
    rest: Option<[u8; 8]>,
}

#[derive(Debug)]
enum ElementCopy {
    /// Bytes that stay the same.
    Bytes,
    /// A `char[N]` of PX4.
    Text,
    /// A string with the maximum number of characters of the target.
    String(Option<u32>),
    Number(Number),
    Message(Program),
}

/// Computes a value by a hint.
#[derive(Debug)]
struct Compute {
    to: usize,
    count: usize,
    scalar: Scalar,
    expression: Expression,
    /// The location and type of each source field, by its index.
    fields: Vec<Option<(usize, Scalar)>>,
}

impl<'t> Converter<'t> {
    /// Compiles a conversion. `source` and `target` are the types of its messages.
    pub fn new(conversion: &Conversion, source: MessageType<'_>, target: MessageType<'t>) -> Self {
        Self {
            target,
            program: compile::program(conversion, source, target),
            keeps_cdr: compile::keeps_cdr(conversion, source, target),
            tests: lost::tests(conversion, source, target),
        }
    }

    /// The type of converted messages.
    pub fn target(&self) -> MessageType<'t> {
        self.target
    }

    /// True if a message has the same CDR payload in both types. Such a message needs no conversion.
    pub fn keeps_cdr(&self) -> bool {
        self.keeps_cdr
    }

    /// Converts a message of the source type.
    pub fn convert(&self, message: &DynamicMessage<'_>) -> Result<DynamicMessage<'t>, TooLarge> {
        let mut run = Run { source: message.memory(), target: self.program.initial.clone() };
        run.program(&self.program, 0, 0).ok_or(TooLarge)?;
        Ok(DynamicMessage::of_memory(self.target, run.target))
    }

    /// Adds 1 to the count of each [loss](Conversion::losses) that changes this message. 0 and NaN, and empty strings
    /// and sequences, are not counted as lost. The losses for which [`Self::is_counted`] is false are never counted.
    pub fn count_losses(&self, message: &DynamicMessage<'_>, counts: &mut [u64]) {
        for (count, test) in counts.iter_mut().zip(&self.tests) {
            *count += u64::from(test.as_ref().is_some_and(|test| test.is_lost(message.memory())));
        }
    }

    /// True if [`Self::count_losses`] counts the loss with this index.
    pub fn is_counted(&self, loss: usize) -> bool {
        self.tests.get(loss).is_some_and(Option::is_some)
    }

    /// True if any loss is counted.
    pub fn counts_losses(&self) -> bool {
        self.tests.iter().any(Option::is_some)
    }
}

struct Run<'r> {
    source: &'r [u8],
    target: Vec<u8>,
}

impl Run<'_> {
    /// Converts the message at `from` and writes the result at `to`. `None` if the target becomes too
    /// large.
    fn program(&mut self, program: &Program, from: usize, to: usize) -> Option<()> {
        for operation in &program.operations {
            match operation {
                Operation::Copy(span) => self.copy(from + span.from, to + span.to, span.size),
                Operation::Transfer(transfer) => self.transfer(transfer, from, to)?,
                Operation::Compute(compute) => self.compute(compute, from, to),
                Operation::Clear(at) => self.put(to + at, &[0; SLOT]),
            }
        }
        Some(())
    }

    #[inline]
    fn copy(&mut self, from: usize, to: usize, size: usize) {
        if let (Some(source), Some(target)) =
            (self.source.get(from..from + size), self.target.get_mut(to..to + size))
        {
            target.copy_from_slice(source);
        }
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        if let Some(target) = self.target.get_mut(at..at + bytes.len()) {
            target.copy_from_slice(bytes);
        }
    }

    fn transfer(&mut self, transfer: &Transfer, from: usize, to: usize) -> Option<()> {
        let Transfer { from: source, to: target, element, rest } = transfer;
        let (start, count) = match source.room {
            Room::Fixed(count) => (from + source.at, count),
            Room::Varying(_) => sequence(self.source, from + source.at),
        };
        let (end, length) = match target.room {
            Room::Fixed(length) => (to + target.at, length),
            Room::Varying(bound) => {
                let length = bound.map_or(count, |bound| count.min(bound as usize));
                (self.open(to + target.at, length, target.stride, element)?, length)
            }
        };
        let copied = count.min(length);
        if matches!(element, ElementCopy::Bytes) {
            self.copy(start, end, copied * target.stride);
        } else {
            for at in 0..copied {
                let places = (start + at * source.stride, end + at * target.stride);
                self.element(element, transfer, places)?;
            }
        }
        if let Some(rest) = rest {
            for at in copied..length {
                self.put(end + at * target.stride, rest.get(..target.stride)?);
            }
        }
        Some(())
    }

    /// Appends the elements of a sequence with their initial values, and returns the location of the first element.
    fn open(&mut self, slot: usize, length: usize, stride: usize, element: &ElementCopy) -> Option<usize> {
        let start = self.append(length.checked_mul(stride)?)?;
        self.point(slot, start, length)?;
        if let ElementCopy::Message(program) = element {
            for at in 0..length {
                self.initialize(program, start + at * stride)?;
            }
        }
        Some(start)
    }

    /// Writes the initial message of a type at `at`, and appends its strings and sequences.
    fn initialize(&mut self, program: &Program, at: usize) -> Option<()> {
        let (fields, rest) = program.initial.split_at_checked(program.size)?;
        self.put(at, fields);
        if rest.is_empty() {
            return Some(());
        }
        let start = self.append(rest.len())?;
        self.put(start, rest);
        let moved = start - program.size;
        for slot in &program.defaults {
            let place = if *slot < program.size { at + slot } else { moved + slot };
            let (first, count) = sequence(&self.target, place);
            self.point(place, first + moved, count)?;
        }
        Some(())
    }

    fn append(&mut self, size: usize) -> Option<usize> {
        let start = self.target.len();
        let end = start.checked_add(size).filter(|end| *end <= MAX_CONVERTED)?;
        self.target.resize(end, 0);
        Some(start)
    }

    /// Writes a slot: the offset of the bytes or elements, and their number.
    fn point(&mut self, slot: usize, start: usize, count: usize) -> Option<()> {
        let bytes = self.target.get_mut(slot..slot + SLOT)?;
        bytes[..4].copy_from_slice(&u32::try_from(start).ok()?.to_le_bytes());
        bytes[4..].copy_from_slice(&u32::try_from(count).ok()?.to_le_bytes());
        Some(())
    }

    fn element(
        &mut self,
        element: &ElementCopy,
        transfer: &Transfer,
        (from, to): (usize, usize),
    ) -> Option<()> {
        match element {
            ElementCopy::Bytes => self.copy(from, to, transfer.to.stride),
            ElementCopy::Text => {
                let text = number::text(part(self.source, from, transfer.from.stride), transfer.to.stride);
                let target = self.target.get_mut(to..to + transfer.to.stride)?;
                target.fill(0);
                target[..text.len()].copy_from_slice(text);
            }
            ElementCopy::String(bound) => {
                let (start, length) = sequence(self.source, from);
                let text = number::characters(part(self.source, start, length), *bound);
                let start = self.append(text.len())?;
                self.put(start, text);
                self.point(to, start, text.len())?;
            }
            ElementCopy::Number(number) => {
                let value = read(number.from, part(self.source, from, transfer.from.stride));
                let converted = number.converted(value);
                let bytes =
                    converted.map_or(transfer.rest.unwrap_or_default(), |value| write(number.to, value));
                self.put(to, bytes.get(..transfer.to.stride)?);
            }
            ElementCopy::Message(program) => self.program(program, from, to)?,
        }
        Some(())
    }

    fn compute(&mut self, compute: &Compute, from: usize, to: usize) {
        let field = |index: usize| match compute.fields.get(index) {
            Some(Some((at, scalar))) => read(*scalar, part(self.source, from + at, scalar.size())),
            _ => super::expression::Computed::Bool(false),
        };
        let bytes = write(compute.scalar, compute.expression.value(&field));
        let size = compute.scalar.size();
        for at in 0..compute.count {
            self.put(to + compute.to + at * size, &bytes[..size]);
        }
    }
}
