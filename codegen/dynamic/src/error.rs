//! Errors in reading, writing and compiling messages.

use std::fmt;

use uavspec_runtime::Fault;

/// An error in reading a message from bytes or JSON, or in converting a message to another form.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    /// The cause.
    pub reason: Reason,
    /// Path to the value in the message, such as `events[2].id`, or the message name if the error concerns the whole
    /// message.
    pub path: String,
    /// Byte offset in the input.
    pub offset: Option<usize>,
}

/// The cause of an [`Error`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// Invalid bytes, or a value that the byte form can't represent.
    Fault(Fault),
    /// Invalid JSON, or a value that JSON can't represent.
    Json(String),
    /// The message has no memory form because its size varies.
    SizeVaries,
    /// The message exceeds 4 GiB in memory.
    TooLarge,
    /// The type is unusable.
    Defect(Defect),
}

/// The reason why a type is unusable.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Defect {
    /// The type contains itself, directly or indirectly.
    Recursive,
    /// Messages nest deeper than this limit.
    TooDeep(usize),
    /// The size exceeds this number of bytes.
    TooLarge(u64),
    /// The type contains an unusable nested type with this name.
    Holds(String),
    /// The definition is unreadable.
    Unreadable,
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.path)?;
        if let Some(offset) = self.offset {
            write!(formatter, " at byte {offset}")?;
        }
        write!(formatter, ": {}", self.reason)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => fault.fmt(formatter),
            Self::Json(text) => formatter.write_str(text),
            Self::SizeVaries => {
                formatter.write_str("expected a message of fixed size, found strings or sequences")
            }
            Self::TooLarge => formatter.write_str("expected a message of at most 4 GiB"),
            Self::Defect(defect) => defect.fmt(formatter),
        }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Recursive => formatter.write_str("contains itself"),
            Self::TooDeep(limit) => write!(formatter, "nests messages more than {limit} levels deep"),
            Self::TooLarge(limit) => write!(formatter, "takes more than {limit} bytes"),
            Self::Holds(name) => write!(formatter, "contains the unusable type `{name}`"),
            Self::Unreadable => formatter.write_str("has an unreadable definition"),
        }
    }
}

impl std::error::Error for Error {}
