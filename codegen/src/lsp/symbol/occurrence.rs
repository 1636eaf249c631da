//! Symbols and their occurrences.

use crate::schema::{JsonMessageId, JsonTypeId, MessageId};
use crate::source::Span;

/// A named thing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::lsp) enum Symbol {
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
}

/// A place where a symbol is written.
#[derive(Clone, Debug)]
pub(in crate::lsp) struct Occurrence {
    pub(in crate::lsp) symbol: Symbol,
    /// The location of the name.
    pub(in crate::lsp) span: Span,
    /// True if the symbol is defined here.
    pub(in crate::lsp) is_definition: bool,
}
