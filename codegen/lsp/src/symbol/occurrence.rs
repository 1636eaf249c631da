//! Symbols and their occurrences.

use uavspec_schema::source::Span;
use uavspec_schema::{EventEnumRef, JsonMessageId, JsonTypeId, MessageId};

/// A named item.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Symbol {
    /// A message.
    Message(MessageId),
    /// A field of a message, by index.
    Field(MessageId, usize),
    /// A constant of a message, by index.
    Constant(MessageId, usize),
    /// The constants of a message that start with a prefix.
    Prefix(MessageId, String),
    /// An error code, by the index of its package and its number.
    ErrorCode(usize, u32),
    /// A type on a page.
    JsonType(JsonTypeId),
    /// A message on a page.
    JsonMessage(JsonMessageId),
    /// An event, by the indices of the package, of the component, and of the event in it.
    Event(usize, usize, usize),
    /// An enum of events, by the index of its package and its location in the package.
    EventEnum(usize, EventEnumRef),
}

/// An occurrence of a symbol.
#[derive(Clone, Debug)]
pub(crate) struct Occurrence {
    pub(crate) symbol: Symbol,
    /// The location of the name.
    pub(crate) span: Span,
    /// True if the symbol is defined here.
    pub(crate) is_definition: bool,
}
