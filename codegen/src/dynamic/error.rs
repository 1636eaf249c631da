//! Why there is no message, or no other form of one.

use std::fmt;

use uavspec_runtime::Fault;

/// Why bytes or JSON are no message of a type, or a message has no such form.
#[derive(Clone, Debug, PartialEq)]
pub struct Error {
    /// What is wrong.
    pub reason: Reason,
    /// Where in the message, as `events[2].id`; the name of the message where it is the message itself.
    pub path: String,
    /// Where in the bytes that were read, from their start.
    pub offset: Option<usize>,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// With bytes, or with a value that is to become bytes.
    Fault(Fault),
    /// With JSON, or with a value that has none.
    Json(String),
    /// The size of the message varies, so it has no memory form.
    SizeVaries,
    /// The message takes more than 4 GiB in memory.
    TooLarge,
    /// Messages of this type can't be handled.
    Defect(Defect),
}

/// Why messages of a type can't be handled.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Defect {
    /// It holds itself, perhaps through others.
    Recursive,
    /// Messages nest deeper in it than this.
    TooDeep(usize),
    /// It takes more bytes than this.
    TooLarge(u64),
    /// It holds a message that can't be handled.
    Holds(String),
    /// It is described in a way that can't be read.
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
                formatter.write_str("expected a message of fixed size, found strings or sequences in it")
            }
            Self::TooLarge => formatter.write_str("expected a message of at most 4 GiB"),
            Self::Defect(defect) => defect.fmt(formatter),
        }
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Recursive => formatter.write_str("holds itself"),
            Self::TooDeep(limit) => write!(formatter, "nests messages deeper than {limit}"),
            Self::TooLarge(limit) => write!(formatter, "takes more than {limit} bytes"),
            Self::Holds(name) => write!(formatter, "holds `{name}`, which can't be used"),
            Self::Unreadable => formatter.write_str("has a definition that can't be read"),
        }
    }
}

impl std::error::Error for Error {}
