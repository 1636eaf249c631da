//! Symbols and their occurrences.

use uavspec_schema::source::Span;
use uavspec_schema::{EventEnumRef, JsonMessageId, JsonTypeId, MessageId};

/// A named thing.
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
    /// An error code of a package, which is given by its index.
    ErrorCode(usize, u32),
    /// A type on a page.
    JsonType(JsonTypeId),
    /// A message on a page.
    JsonMessage(JsonMessageId),
    /// An event of a package: the indices of the package, of the component, and of the event in it.
    Event(usize, usize, usize),
    /// An enum of the events of a package, which is given by its index.
    EventEnum(usize, EventEnumRef),
}

/// A place where a symbol is written.
#[derive(Clone, Debug)]
pub(crate) struct Occurrence {
    pub(crate) symbol: Symbol,
    /// The location of the name.
    pub(crate) span: Span,
    /// True if the symbol is defined here.
    pub(crate) is_definition: bool,
}
