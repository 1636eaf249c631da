//! Problems with data, formats and subscriptions.

use std::fmt;

use uavspec_dynamic::{FormatError, FormatProblem};

use crate::limits::{MAX_FORMAT_TEXT, MAX_FORMATS};

/// A problem with a log's data, formats or subscriptions.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LogProblem {
    /// A format is invalid.
    Format {
        /// The name.
        name: String,
        /// The problem.
        problem: FormatProblem,
    },
    /// A format is repeated with different fields. From here on, its data can't be decoded.
    FormatChanged {
        /// The name.
        name: String,
    },
    /// A format appears after the definitions section, but is still used.
    LateFormat {
        /// The name.
        name: String,
    },
    /// There are too many formats. This format and all later formats are ignored.
    TooManyFormats,
    /// The total size of formats and topics is too large. This format or subscription is ignored.
    TooMuchText,
    /// Too many formats appear late, so types are no longer compiled. Later formats are ignored.
    TooManyLateFormats,
    /// An id is subscribed again to the same topic.
    Resubscribed {
        /// The id.
        id: u16,
    },
    /// An id is subscribed to a different topic than before. From here on, the id refers to the new topic.
    Redefined {
        /// The id.
        id: u16,
        /// The previous topic and instance.
        before: (String, u8),
        /// The new topic and instance.
        after: (String, u8),
    },
    /// Data with an id appears before the id is subscribed.
    LateSubscription {
        /// The id.
        id: u16,
        /// The number of messages. Each message is also reported.
        count: u64,
        /// The offset of the first message.
        first: u64,
    },
    /// An id is unsubscribed, but had no subscription.
    NotSubscribed {
        /// The id.
        id: u16,
    },
    /// Data with an id that has no earlier subscription.
    UnknownId {
        /// The id.
        id: u16,
    },
    /// Data with an id that was unsubscribed.
    Unsubscribed {
        /// The id.
        id: u16,
    },
    /// Data of a topic without a format.
    MissingFormat {
        /// The id.
        id: u16,
    },
    /// Data of a topic with an invalid format.
    UnusableFormat {
        /// The id.
        id: u16,
    },
    /// Data with a size that doesn't match the format, either with or without the trailing padding.
    DataSize {
        /// The id.
        id: u16,
        /// The size of the format, in bytes.
        padded: usize,
        /// The size of the format without the padding at the end, in bytes.
        no_padding: usize,
        /// The size of the data, in bytes.
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
                "format `{}` is declared again with different fields; data after this can't be decoded",
                name.escape_debug()
            ),
            Self::LateFormat { name } => {
                write!(formatter, "format `{}` appears after the definitions section", name.escape_debug())
            }
            Self::TooManyFormats => {
                write!(formatter, "there are more than {MAX_FORMATS} formats; the rest are ignored")
            }
            Self::TooMuchText => {
                write!(
                    formatter,
                    "ignored a format or topic: the limit for all formats and topics together is {MAX_FORMAT_TEXT} bytes"
                )
            }
            Self::TooManyLateFormats => formatter
                .write_str("too many formats appear after the definitions section; later ones are ignored"),
            Self::Resubscribed { id } => write!(formatter, "id {id} is subscribed again"),
            Self::Redefined { id, before, after } => write!(
                formatter,
                "id {id} changes from `{}` instance {} to `{}` instance {}",
                before.0.escape_debug(),
                before.1,
                after.0.escape_debug(),
                after.1
            ),
            Self::LateSubscription { id, count, first } => {
                write!(
                    formatter,
                    "{count} messages with id {id} precede its subscription; the first is at byte {first}"
                )
            }
            Self::NotSubscribed { id } => write!(formatter, "id {id} is unsubscribed, but wasn't subscribed"),
            Self::UnknownId { id } => write!(formatter, "data for id {id}, which isn't subscribed"),
            Self::Unsubscribed { id } => write!(formatter, "data for id {id}, which was unsubscribed"),
            Self::MissingFormat { id } => write!(formatter, "data for id {id}, whose topic has no format"),
            Self::UnusableFormat { id } => {
                write!(formatter, "data for id {id}, whose format is invalid")
            }
            Self::DataSize { id, padded, no_padding, found } if padded == no_padding => {
                write!(formatter, "expected {padded} bytes of data for id {id}, found {found}")
            }
            Self::DataSize { id, padded, no_padding, found } => {
                write!(
                    formatter,
                    "expected {padded} or {no_padding} bytes of data for id {id}, found {found}"
                )
            }
        }
    }
}
