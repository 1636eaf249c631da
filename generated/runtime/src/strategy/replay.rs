//! Decodes a message from the drawn values.

use std::mem;
use std::string::String;
use std::vec::{IntoIter, Vec};

use super::tree::Node;
use crate::descriptor::{MessageDescriptor, Shape};
use crate::record::{FieldSource, Primitive, Record, Source, Value};

/// All values of a message, in the order in which the message reads them.
#[derive(Default)]
pub(super) struct Script {
    /// The bits of each number, the length of each sequence, and each byte of text.
    pub(super) numbers: Vec<u64>,
    pub(super) strings: Vec<String>,
}

/// Reads a message from a [`Script`], without enforcing bounds as codecs do.
pub(super) struct Replay {
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    numbers: IntoIter<u64>,
    strings: IntoIter<String>,
}

impl Replay {
    pub(super) fn of(root: &Node) -> Self {
        let mut script = Script::default();
        root.write(&mut script);
        let Script { numbers, strings } = script;
        Self { message: &MessageDescriptor::NONE, numbers: numbers.into_iter(), strings: strings.into_iter() }
    }

    pub(super) fn message<M: Record>(mut self) -> M {
        Source::message(&mut self)
    }
}

impl FieldSource for Replay {
    fn field<T: Value>(&mut self, index: usize) -> T {
        T::read(self, &self.message.fields[index])
    }
}

impl Source for Replay {
    fn scalar<P: Primitive>(&mut self) -> P {
        P::read_le(&self.numbers.next().unwrap_or_default().to_le_bytes())
    }

    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        values.fill_with(|| self.scalar());
    }

    fn length(&mut self, _: Shape, _: usize) -> usize {
        self.numbers.next().and_then(|length| usize::try_from(length).ok()).unwrap_or_default()
    }

    fn string(&mut self, _: bool, _: Option<u32>) -> String {
        self.strings.next().unwrap_or_default()
    }

    fn message<M: Record>(&mut self) -> M {
        let outer = mem::replace(&mut self.message, M::DESCRIPTOR);
        let message = M::read_fields(self);
        self.message = outer;
        message
    }

    fn has_failed(&self) -> bool {
        false
    }

    fn locate_fault(&mut self, _: usize) {}
}
