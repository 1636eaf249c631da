//! Messages that own their bytes.

use std::fmt;

use super::types::MessageType;
use super::view::{DynamicView, Value};

/// A message.
#[derive(Clone)]
pub struct DynamicMessage<'t> {
    pub(super) of: MessageType<'t>,
    /// The fields, and behind them strings and the elements of sequences.
    pub(super) buffer: Vec<u8>,
}

impl<'t> DynamicMessage<'t> {
    /// Its type.
    pub fn message_type(&self) -> MessageType<'t> {
        self.of
    }

    /// Looks at it.
    pub fn view(&self) -> DynamicView<'_> {
        DynamicView { types: self.of.types, plan: self.of.plan, bytes: &self.buffer, base: 0 }
    }

    /// The value that a path such as `events[2].id` leads to, if there is one.
    pub fn get(&self, path: &str) -> Option<Value<'_>> {
        self.view().get(path)
    }

    /// Its bytes in memory, as [`MessageType::layout`] places its fields; a `bool` is the byte that was read.
    pub fn memory(&self) -> &[u8] {
        &self.buffer
    }

    /// How many bytes it takes in memory.
    pub fn size_in_memory(&self) -> usize {
        self.buffer.len()
    }
}

impl fmt::Debug for DynamicMessage<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.view().fmt(formatter)
    }
}
