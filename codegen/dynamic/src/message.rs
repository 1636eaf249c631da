//! Messages that own their bytes.

use std::fmt;

use super::types::MessageType;
use super::view::{DynamicView, Value};

/// A message whose type is known only at run time.
#[derive(Clone)]
pub struct DynamicMessage<'t> {
    pub(super) ty: MessageType<'t>,
    /// The fields, followed by strings and elements of sequences.
    pub(super) buffer: Vec<u8>,
}

impl<'t> DynamicMessage<'t> {
    /// Creates a message from its bytes in memory.
    pub(crate) fn of_memory(ty: MessageType<'t>, buffer: Vec<u8>) -> Self {
        Self { ty, buffer }
    }

    /// Type of the message.
    pub fn message_type(&self) -> MessageType<'t> {
        self.ty
    }

    /// Borrows the message as a view.
    pub fn view(&self) -> DynamicView<'_> {
        DynamicView { types: self.ty.types, plan: self.ty.plan, bytes: &self.buffer, base: 0 }
    }

    /// The value at a path such as `events[2].id`, if it exists.
    pub fn get(&self, path: &str) -> Option<Value<'_>> {
        self.view().get(path)
    }

    /// The bytes in memory, in the layout of [`MessageType::fields`]. The byte of a `bool` is not normalized.
    pub fn memory(&self) -> &[u8] {
        &self.buffer
    }

    /// The bytes in memory; see [`Self::memory`].
    pub fn into_memory(self) -> Vec<u8> {
        self.buffer
    }

    /// Size in memory in bytes.
    pub fn size_in_memory(&self) -> usize {
        self.buffer.len()
    }
}

impl fmt::Debug for DynamicMessage<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.view().fmt(formatter)
    }
}
