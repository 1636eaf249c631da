//! Reads a message from generated values.

use std::mem;
use std::string::String;
use std::vec::{IntoIter, Vec};

use crate::descriptor::{MessageDescriptor, Shape};
use crate::record::{FieldSource, Primitive, Record, Source, Value};

/// Values of a message, in the order in which the message reads them.
#[derive(Clone, Debug)]
pub(super) enum Node {
    /// The bits of a number, the length of a sequence, or a byte of text.
    Number(u64),
    String(String),
    /// The fields of a message, or the elements of a field.
    Group(Vec<Node>),
}

impl Node {
    /// Reads a message. Unlike codecs, doesn't enforce bounds.
    pub(super) fn message<M: Record>(self) -> M {
        let mut leaves = Vec::new();
        self.append_to(&mut leaves);
        Source::message(&mut Replay { message: &MessageDescriptor::NONE, leaves: leaves.into_iter() })
    }

    /// Appends the numbers and strings to `leaves`.
    fn append_to(self, leaves: &mut Vec<Self>) {
        match self {
            Self::Number(_) | Self::String(_) => leaves.push(self),
            Self::Group(nodes) => nodes.into_iter().for_each(|node| node.append_to(leaves)),
        }
    }
}

struct Replay {
    /// The message whose fields are read.
    message: &'static MessageDescriptor,
    /// The numbers and strings that remain.
    leaves: IntoIter<Node>,
}

impl Replay {
    fn number(&mut self) -> u64 {
        match self.leaves.next() {
            Some(Node::Number(bits)) => bits,
            Some(Node::String(_) | Node::Group(_)) | None => 0,
        }
    }
}

impl FieldSource for Replay {
    fn field<T: Value>(&mut self, index: usize) -> T {
        T::read(self, &self.message.fields[index])
    }
}

impl Source for Replay {
    fn scalar<P: Primitive>(&mut self) -> P {
        P::read_le(&self.number().to_le_bytes())
    }

    fn scalars<P: Primitive>(&mut self, values: &mut [P]) {
        values.fill_with(|| self.scalar());
    }

    fn length(&mut self, _: Shape, _: usize) -> usize {
        usize::try_from(self.number()).unwrap_or_default()
    }

    fn string(&mut self, _: bool, _: Option<u32>) -> String {
        match self.leaves.next() {
            Some(Node::String(text)) => text,
            Some(Node::Number(_) | Node::Group(_)) | None => String::new(),
        }
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
