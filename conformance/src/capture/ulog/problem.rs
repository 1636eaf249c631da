//! What can be wrong with a log.

use std::fmt;

use crate::model::Extent;

/// What is wrong with the bytes of a log. The offset of its item is that of the header or of the first byte
/// that it is about.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The file is no `ULog`; nothing follows.
    ForeignMagic([u8; 7]),
    /// The file has fewer than the 16 bytes of its header; nothing follows.
    ShortHeader {
        /// How many it has.
        found: usize,
    },
    /// The version is newer than 1. Reading goes on.
    NewerVersion(u8),
    /// The first message isn't `B`. Logs of version 0 have none.
    NoFlagBits {
        /// The version of the log.
        version: u8,
    },
    /// A `B` that isn't the first message. It has no effect.
    FlagBitsNotFirst,
    /// `B` is longer than the 40 bytes that are known; the others have no effect.
    FlagBitsLonger {
        /// Bytes of its payload.
        size: usize,
    },
    /// A bit is set that only those may ignore who know it; nothing follows.
    UnknownIncompatible([u8; 8]),
    /// The offset of appended data has no effect: it isn't behind the one before, or the bit that belongs to
    /// it isn't set.
    AppendedOffset(u64),
    /// The log ends before the data that was appended there.
    AppendedBeyondEnd(u64),
    /// The log ends within the header of a message.
    EndsInHeader {
        /// Bytes that are there.
        found: usize,
    },
    /// The log ends within the payload of a message.
    EndsInPayload {
        /// Kind of the message.
        kind: u8,
        /// Bytes of its payload.
        size: usize,
        /// Bytes that are there.
        found: usize,
    },
    /// A message was cut off where data was appended, and is dropped. Reading goes on with that data.
    Straddles {
        /// Where the appended data begins.
        appended: u64,
    },
    /// Messages of a kind that isn't known. They are lent, and this is told after the first one.
    UnknownKind(u8),
    /// Bytes that are no messages, or of messages whose size can't be right, up to `to`.
    Skipped {
        /// Offset of the first byte that is read again.
        to: u64,
        /// What is there.
        resync: Resync,
    },
    /// Nothing of a message can be used, so it is dropped.
    Malformed {
        /// Its kind.
        kind: u8,
        /// Bytes of its payload.
        size: usize,
        /// What is wrong.
        malformation: Malformation,
    },
    /// Something is wrong with the message that was lent just before.
    Odd {
        /// Its kind.
        kind: u8,
        /// What is wrong.
        malformation: Malformation,
    },
}

/// How a reader found its way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Resync {
    /// A sync message.
    Synchronisation,
    /// Several messages that follow each other.
    Messages,
    /// It didn't, until data that was appended.
    Appended,
    /// It didn't, until the log ended.
    End,
}

/// What is wrong with the contents of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Malformation {
    /// It is shorter than its kind needs.
    TooShort {
        /// Bytes of its payload.
        size: usize,
        /// The least that is needed.
        least: usize,
    },
    /// Its key goes beyond its end.
    KeyLength {
        /// Length of the key.
        length: usize,
        /// Bytes that are left.
        room: usize,
    },
    /// Its text isn't UTF-8.
    NotUtf8 {
        /// Where, from the start of the payload.
        at: usize,
    },
    /// Its value is text, but not UTF-8.
    ValueNotUtf8,
    /// No colon ends the name of a format.
    NoColon,
    /// Its key isn't a type and a name with a blank between.
    NoType,
    /// A name in it has no characters.
    NoName,
    /// Its value isn't as long as its type.
    ValueSize {
        /// Bytes of the type.
        expected: u64,
        /// Bytes of the value.
        found: usize,
    },
    /// It isn't the magic of a sync message.
    SyncMagic,
}

impl Problem {
    /// How much of the log can be read that has it.
    pub fn extent(&self) -> Extent {
        match self {
            Self::ForeignMagic(_)
            | Self::ShortHeader { .. }
            | Self::UnknownIncompatible(_)
            | Self::Skipped { .. }
            | Self::Malformed { .. } => Extent::WithGaps,
            Self::AppendedBeyondEnd(_) | Self::EndsInHeader { .. } | Self::EndsInPayload { .. } => {
                Extent::EndsEarly
            }
            Self::NewerVersion(_)
            | Self::NoFlagBits { .. }
            | Self::FlagBitsNotFirst
            | Self::FlagBitsLonger { .. }
            | Self::AppendedOffset(_)
            // What writes such logs cuts the message off.
            | Self::Straddles { .. }
            | Self::UnknownKind(_)
            | Self::Odd { .. } => Extent::Whole,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ForeignMagic(found) => {
                write!(formatter, "expected the magic of ULog, found {}", found.escape_ascii())
            }
            Self::ShortHeader { found } => {
                write!(formatter, "expected a header of 16 bytes, found {found}")
            }
            Self::NewerVersion(version) => {
                write!(formatter, "the log has version {version}; versions up to 1 are known")
            }
            Self::NoFlagBits { version } => {
                write!(formatter, "the log has no flag bits (version {version})")
            }
            Self::FlagBitsNotFirst => {
                formatter.write_str("flag bits have no effect unless they are the first message")
            }
            Self::FlagBitsLonger { size } => {
                write!(formatter, "flag bits take {size} bytes; 40 are known")
            }
            Self::UnknownIncompatible(bits) => write!(
                formatter,
                "the log needs a reader that knows more than this one: incompatible bits {bits:02x?}"
            ),
            Self::AppendedOffset(offset) => {
                write!(formatter, "no data is looked for at {offset}, where it is said to be appended")
            }
            Self::AppendedBeyondEnd(offset) => {
                write!(formatter, "the log ends before the data that is said to be appended at {offset}")
            }
            Self::EndsInHeader { found } => {
                write!(formatter, "the log ends within a header, after {found} of 3 bytes")
            }
            Self::EndsInPayload { kind, size, found } => write!(
                formatter,
                "the log ends within a message `{}`, after {found} of {size} bytes",
                kind.escape_ascii()
            ),
            Self::Straddles { appended } => {
                write!(formatter, "a message is cut off by the data appended at {appended}")
            }
            Self::UnknownKind(kind) => {
                write!(formatter, "messages `{}` are of a kind that isn't known", kind.escape_ascii())
            }
            Self::Skipped { to, resync } => write!(formatter, "no messages up to {to}, {resync}"),
            Self::Malformed { kind, size, malformation } => {
                write!(
                    formatter,
                    "a message `{}` of {size} bytes is dropped: {malformation}",
                    kind.escape_ascii()
                )
            }
            Self::Odd { kind, malformation } => {
                write!(formatter, "message `{}`: {malformation}", kind.escape_ascii())
            }
        }
    }
}

impl fmt::Display for Resync {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Synchronisation => "where a sync message is",
            Self::Messages => "where messages follow each other again",
            Self::Appended => "where data was appended",
            Self::End => "the end of the log",
        })
    }
}

impl fmt::Display for Malformation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { size, least } => {
                write!(formatter, "expected at least {least} bytes, found {size}")
            }
            Self::KeyLength { length, room } => {
                write!(formatter, "its key takes {length} bytes where {room} are left")
            }
            Self::NotUtf8 { at } => write!(formatter, "byte {at} of it isn't UTF-8"),
            Self::ValueNotUtf8 => formatter.write_str("its value is text, but isn't UTF-8"),
            Self::NoColon => formatter.write_str("expected a name and a colon"),
            Self::NoType => formatter.write_str("expected a type, a blank and a name"),
            Self::NoName => formatter.write_str("a name in it is empty"),
            Self::ValueSize { expected, found } => {
                write!(formatter, "expected a value of {expected} bytes, found {found}")
            }
            Self::SyncMagic => formatter.write_str("it isn't the magic of a sync message"),
        }
    }
}

impl std::error::Error for Problem {}

impl std::error::Error for Malformation {}
