//! Problems in the bytes of a log.

use std::fmt;

use uavspec_model::Extent;

/// A problem in the bytes of a log. The item's offset is the offset of the message header or of the first affected
/// byte.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The file isn't a `ULog`. Reading stops.
    ForeignMagic([u8; 7]),
    /// The file is shorter than its 16-byte header. Reading stops.
    ShortHeader {
        /// The number of bytes.
        found: usize,
    },
    /// The version is newer than 1. Reading continues.
    NewerVersion(u8),
    /// The first message isn't `B`. Logs of version 0 have no `B`.
    NoFlagBits {
        /// The version of the log.
        version: u8,
    },
    /// A `B` that isn't the first message is ignored.
    FlagBitsNotFirst,
    /// `B` is longer than the 40 known bytes; the rest are ignored.
    FlagBitsLonger {
        /// The size of the payload, in bytes.
        size: usize,
    },
    /// An unknown bit that readers must not ignore is set. Reading stops.
    UnknownIncompatible([u8; 8]),
    /// An offset of appended data is ignored, because it doesn't follow the previous offset or because the bit for
    /// appended data isn't set.
    AppendedOffset(u64),
    /// The log ends before this offset of appended data.
    AppendedBeyondEnd(u64),
    /// The log ends within the header of a message.
    EndsInHeader {
        /// The number of available bytes.
        found: usize,
    },
    /// The log ends within the payload of a message.
    EndsInPayload {
        /// The kind of the message.
        kind: u8,
        /// The size of the payload, in bytes.
        size: usize,
        /// The number of available bytes.
        found: usize,
    },
    /// A message is truncated by the start of appended data, and is skipped. Reading continues with the appended data.
    Straddles {
        /// The offset of the appended data.
        appended: u64,
    },
    /// Messages of an unknown kind. All messages are returned, but only the first message is reported.
    UnknownKind(u8),
    /// Bytes that aren't messages, or messages of an impossible size.
    Skipped {
        /// The offset at which reading continues.
        to: u64,
        /// The reason why reading continues there.
        resync: Resync,
    },
    /// A message is unusable and is skipped.
    Malformed {
        /// The kind.
        kind: u8,
        /// The size of the payload, in bytes.
        size: usize,
        /// The problem.
        malformation: Malformation,
    },
    /// The most recently returned message has a problem.
    InvalidContent {
        /// The kind.
        kind: u8,
        /// The problem.
        malformation: Malformation,
    },
}

/// The point at which reading continues after corruption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Resync {
    /// A sync message.
    Synchronisation,
    /// Several consecutive messages.
    Messages,
    /// The start of appended data. The search found no messages before this data.
    Appended,
    /// The end of the log. The search found no messages before the end.
    End,
}

/// A problem with the content of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Malformation {
    /// The payload is shorter than the minimum for its kind.
    TooShort {
        /// The size of the payload, in bytes.
        size: usize,
        /// The minimum size, in bytes.
        min: usize,
    },
    /// The payload is longer than all messages of its kind.
    TooLong {
        /// The size of the payload, in bytes.
        size: usize,
        /// The maximum size, in bytes.
        max: usize,
    },
    /// A line of text has a level that doesn't exist.
    Level(u8),
    /// The key extends beyond the end of the message.
    KeyLength {
        /// The length of the key.
        length: usize,
        /// The number of bytes left.
        room: usize,
    },
    /// The text is invalid UTF-8.
    NotUtf8 {
        /// The offset in the payload.
        at: usize,
    },
    /// A text value is invalid UTF-8.
    ValueNotUtf8,
    /// A format lacks the colon after its name.
    NoColon,
    /// A key doesn't consist of a type and a name separated by a space.
    NoType,
    /// A name is empty.
    NoName,
    /// The size of a value doesn't match its type.
    ValueSize {
        /// The size of the type, in bytes.
        expected: u64,
        /// The size of the value, in bytes.
        found: usize,
    },
    /// The payload isn't the magic of a sync message.
    SyncMagic,
}

impl Problem {
    /// True if all messages can be read despite this problem.
    pub fn is_harmless(&self) -> bool {
        matches!(self, Self::NoFlagBits { .. } | Self::FlagBitsLonger { .. })
    }

    /// The extent to which the log can be read despite this problem.
    pub fn extent(&self) -> Extent {
        match self {
            Self::ForeignMagic(_)
            | Self::ShortHeader { .. }
            | Self::UnknownIncompatible(_)
            | Self::Skipped { .. }
            // The kind of such a message may be corrupt.
            | Self::UnknownKind(_)
            | Self::Malformed { .. } => Extent::WithGaps,
            Self::AppendedBeyondEnd(_)
            | Self::EndsInHeader { .. }
            | Self::EndsInPayload { .. }
            | Self::Straddles { .. } => Extent::EndsEarly,
            Self::NewerVersion(_)
            | Self::NoFlagBits { .. }
            | Self::FlagBitsNotFirst
            | Self::FlagBitsLonger { .. }
            | Self::AppendedOffset(_)
            | Self::InvalidContent { .. } => Extent::Whole,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ForeignMagic(found) => {
                write!(formatter, "expected the magic bytes of ULog, found {}", found.escape_ascii())
            }
            Self::ShortHeader { found } => {
                write!(formatter, "expected a header of 16 bytes, found {found}")
            }
            Self::NewerVersion(version) => {
                write!(formatter, "the log has version {version}; versions up to 1 are supported")
            }
            Self::NoFlagBits { version } => {
                write!(formatter, "the log has no flag bits (version {version})")
            }
            Self::FlagBitsNotFirst => {
                formatter.write_str("flag bits are ignored unless they are the first message")
            }
            Self::FlagBitsLonger { size } => {
                write!(formatter, "expected 40 bytes of flag bits, found {size}; the rest are ignored")
            }
            Self::UnknownIncompatible(bits) => {
                write!(formatter, "the log uses unsupported features: incompatible bits {bits:02x?}")
            }
            Self::AppendedOffset(offset) => {
                write!(formatter, "ignored an invalid offset of appended data: {offset}")
            }
            Self::AppendedBeyondEnd(offset) => {
                write!(formatter, "the log ends before the data appended at byte {offset}")
            }
            Self::EndsInHeader { found } => {
                write!(formatter, "the log is truncated within a message header, after {found} of 3 bytes")
            }
            Self::EndsInPayload { kind, size, found } => write!(
                formatter,
                "the log is truncated within a `{}` message, after {found} of {size} bytes",
                kind.escape_ascii()
            ),
            Self::Straddles { appended } => {
                write!(formatter, "a message is truncated by the data appended at byte {appended}")
            }
            Self::UnknownKind(kind) => {
                write!(formatter, "`{}` is an unknown message kind", kind.escape_ascii())
            }
            Self::Skipped { to, resync } => write!(formatter, "no valid messages up to byte {to}, {resync}"),
            Self::Malformed { kind, size, malformation } => {
                write!(
                    formatter,
                    "skipped a `{}` message of {size} bytes: {malformation}",
                    kind.escape_ascii()
                )
            }
            Self::InvalidContent { kind, malformation } => {
                write!(formatter, "`{}` message: {malformation}", kind.escape_ascii())
            }
        }
    }
}

impl fmt::Display for Resync {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Synchronisation => "where there is a sync message",
            Self::Messages => "where valid messages follow",
            Self::Appended => "where appended data starts",
            Self::End => "the end of the log",
        })
    }
}

impl fmt::Display for Malformation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { size, min } => {
                write!(formatter, "expected at least {min} bytes, found {size}")
            }
            Self::TooLong { size, max } => write!(formatter, "expected {max} bytes, found {size}"),
            Self::Level(level) => {
                write!(formatter, "expected a level from `0` to `7`, found `{}`", level.escape_ascii())
            }
            Self::KeyLength { length, room } => {
                write!(formatter, "expected a key of {length} bytes, found {room} bytes")
            }
            Self::NotUtf8 { at } => write!(formatter, "invalid UTF-8 at byte {at} of its payload"),
            Self::ValueNotUtf8 => formatter.write_str("its string value is invalid UTF-8"),
            Self::NoColon => formatter.write_str("expected a name and a colon"),
            Self::NoType => formatter.write_str("expected a type, a space and a name"),
            Self::NoName => formatter.write_str("its name is empty"),
            Self::ValueSize { expected, found } => {
                write!(formatter, "expected a value of {expected} bytes, found {found}")
            }
            Self::SyncMagic => formatter.write_str("expected the magic bytes of a sync message"),
        }
    }
}
