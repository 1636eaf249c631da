//! Decoding and encoding errors.

use core::fmt;

use crate::Path;

/// The cause of a decoding or encoding error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// A uORB payload has neither the full size nor the size without the padding at the end.
    Size {
        /// Size with the padding.
        padded: usize,
        /// Size without the padding.
        no_padding: usize,
        /// Size of the payload.
        found: usize,
    },
    /// The bytes end inside a value.
    Truncated {
        /// Size of the value in bytes, or its minimum if the size varies.
        needed: usize,
        /// Number of bytes left.
        left: usize,
    },
    /// The first two bytes of a CDR payload identify an unsupported encoding.
    Encapsulation([u8; 2]),
    /// A sequence or string is longer than its bound.
    TooLong {
        /// Maximum number of elements or characters.
        bound: u32,
        /// Number of elements or characters found.
        found: usize,
    },
    /// A string is not valid UTF-8, or a wide string is not valid UTF-16.
    NotUnicode,
    /// A string doesn't end with a NUL, or contains a NUL before its end.
    Nul,
    /// A `bool` is neither 0 nor 1. Reported only in strict mode.
    Bool(u8),
    /// More bytes follow the message and its padding.
    Trailing(usize),
    /// The output buffer is too small.
    Buffer {
        /// Size of the message in bytes.
        needed: usize,
        /// Size of the buffer in bytes.
        room: usize,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Size { padded, no_padding, found } if padded == no_padding => {
                write!(formatter, "expected {padded} bytes, found {found}")
            }
            Self::Size { padded, no_padding, found } => {
                write!(
                    formatter,
                    "expected {padded} bytes ({no_padding} without the trailing padding), found {found}"
                )
            }
            Self::Truncated { needed, left } => {
                let bytes = if needed == 1 { "byte" } else { "bytes" };
                write!(formatter, "expected {needed} more {bytes}, found {left}")
            }
            Self::Encapsulation([first, second]) => write!(
                formatter,
                "expected a CDR payload that starts with 00 01 (little endian) or 00 00 (big endian), found {first:02x} \
                 {second:02x}"
            ),
            Self::TooLong { bound, found } => write!(formatter, "expected at most {bound}, found {found}"),
            Self::NotUnicode => formatter.write_str("expected a Unicode string, found invalid bytes"),
            Self::Nul => formatter.write_str("expected a string with a single NUL at the end"),
            Self::Bool(byte) => write!(formatter, "expected 0 or 1, found {byte}"),
            Self::Trailing(count) => {
                write!(formatter, "expected the end of the payload, found {count} more bytes")
            }
            Self::Buffer { needed, room } => {
                write!(formatter, "expected a buffer of at least {needed} bytes, found {room}")
            }
        }
    }
}

/// An error while decoding a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecodeError {
    /// The cause.
    pub fault: Fault,
    /// Byte offset from the start of the payload.
    pub offset: usize,
    /// The field or element.
    pub path: Path,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} at byte {}: {}", self.path, self.offset, self.fault)
    }
}

/// An error while encoding a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodeError {
    /// The cause.
    pub fault: Fault,
    /// The field or element.
    pub path: Path,
}

impl fmt::Display for EncodeError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.path, self.fault)
    }
}

#[cfg(feature = "std")]
impl std::error::Error for DecodeError {}

#[cfg(feature = "std")]
impl std::error::Error for EncodeError {}
