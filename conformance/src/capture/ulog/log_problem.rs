//! What can be wrong with data, formats and subscriptions.

use std::fmt;

use uavspec_codegen::dynamic::{FormatError, FormatProblem};

/// Most formats that are kept. PX4 has 261 messages; there are 65,536 ids of data, but no such logs.
pub(super) const MAX_FORMATS: usize = 8_192;

/// Most bytes of formats and topics that are kept. The formats of real logs take 22 to 32 kB. Types take up
/// to fifty times the room of their text, so memory is bounded at some 50 MB for a log that is made to take
/// much.
pub(super) const MAX_TEXT: usize = 1 << 20;

/// What is wrong with the data of a log, or with what is said about it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LogProblem {
    /// A format can't be used.
    Format {
        /// Its name.
        name: String,
        /// What is wrong.
        problem: FormatProblem,
    },
    /// A format came again with other fields; the first one is used.
    FormatChanged {
        /// Its name.
        name: String,
    },
    /// A format came after the definitions had ended. It is used all the same.
    LateFormat {
        /// Its name.
        name: String,
    },
    /// There are more formats than are kept; this one and those after it aren't used.
    TooManyFormats,
    /// Formats and topics take more room than is kept; this one isn't used.
    TooMuchText,
    /// Formats came late so often that the types are no longer made anew; those from here on aren't used.
    TooManyLateFormats,
    /// An id was subscribed again, to the same topic.
    Resubscribed {
        /// The id.
        id: u16,
    },
    /// An id was subscribed again, to another topic, which is used from here on.
    Redefined {
        /// The id.
        id: u16,
        /// Topic and instance until now.
        before: (String, u8),
        /// Topic and instance from here on.
        after: (String, u8),
    },
    /// Data of an id came before its subscription.
    LateSubscription {
        /// The id.
        id: u16,
        /// How many messages; each was told.
        count: u64,
        /// Offset of the first one.
        first: u64,
    },
    /// An id was unsubscribed that wasn't subscribed.
    NotSubscribed {
        /// The id.
        id: u16,
    },
    /// Data of an id that isn't subscribed, or not yet.
    UnknownId {
        /// The id.
        id: u16,
    },
    /// Data of an id that was unsubscribed.
    Unsubscribed {
        /// The id.
        id: u16,
    },
    /// Data of a topic that has no format.
    MissingFormat {
        /// Its id.
        id: u16,
    },
    /// Data of a topic whose format can't be used.
    UnusableFormat {
        /// Its id.
        id: u16,
    },
    /// Data that is neither as long as its format nor as that without the padding at its end.
    DataSize {
        /// Its id.
        id: u16,
        /// Bytes of the format.
        padded: usize,
        /// Bytes of the format without the padding at its end.
        no_padding: usize,
        /// Bytes of the data.
        found: usize,
    },
}

impl fmt::Display for LogProblem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format { name, problem } => {
                let error = FormatError { index: 0, name: name.clone(), problem: problem.clone() };
                error.fmt(formatter)
            }
            Self::FormatChanged { name } => write!(
                formatter,
                "format `{}` came before with other fields; the first one is used",
                name.escape_debug()
            ),
            Self::LateFormat { name } => {
                write!(formatter, "format `{}` comes after the definitions", name.escape_debug())
            }
            Self::TooManyFormats => {
                write!(formatter, "there are more than {MAX_FORMATS} formats; the others aren't used")
            }
            Self::TooMuchText => {
                write!(formatter, "formats and topics take more than {MAX_TEXT} bytes; this one isn't used")
            }
            Self::TooManyLateFormats => {
                formatter.write_str("formats come late too often; those from here on aren't used")
            }
            Self::Resubscribed { id } => write!(formatter, "id {id} is subscribed again"),
            Self::Redefined { id, before, after } => write!(
                formatter,
                "id {id} was `{}` {} and is `{}` {} from here on",
                before.0.escape_debug(),
                before.1,
                after.0.escape_debug(),
                after.1
            ),
            Self::LateSubscription { id, count, first } => {
                write!(formatter, "{count} messages of id {id} came before its subscription, from {first} on")
            }
            Self::NotSubscribed { id } => write!(formatter, "id {id} is unsubscribed, but wasn't subscribed"),
            Self::UnknownId { id } => write!(formatter, "data of id {id}, which isn't subscribed"),
            Self::Unsubscribed { id } => write!(formatter, "data of id {id}, which was unsubscribed"),
            Self::MissingFormat { id } => write!(formatter, "data of id {id}, whose topic has no format"),
            Self::UnusableFormat { id } => {
                write!(formatter, "data of id {id}, whose format can't be used")
            }
            Self::DataSize { id, padded, no_padding, found } if padded == no_padding => {
                write!(formatter, "expected {padded} bytes of data of id {id}, found {found}")
            }
            Self::DataSize { id, padded, no_padding, found } => {
                write!(formatter, "expected {padded} or {no_padding} bytes of data of id {id}, found {found}")
            }
        }
    }
}

impl std::error::Error for LogProblem {}
