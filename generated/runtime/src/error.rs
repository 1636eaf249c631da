//! Why bytes are no message, or a message has no bytes.

use core::fmt;

use crate::Path;

/// What is wrong with the bytes of a message, or with a value that is to become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// A uORB payload has neither the full size nor the size without the padding at the end.
    Size {
        /// Bytes with the padding.
        padded: usize,
        /// Bytes without it.
        no_padding: usize,
        /// Bytes that there are.
        found: usize,
    },
    /// The bytes end inside a value.
    Truncated {
        /// Bytes that the value takes, or the least that it can take.
        needed: usize,
        /// Bytes that are left.
        left: usize,
    },
    /// The first two bytes of a CDR payload name no encoding that is known here.
    Encapsulation([u8; 2]),
    /// A sequence or string is longer than its bound.
    TooLong {
        /// Greatest number of elements or characters.
        bound: u32,
        /// How many there are.
        found: usize,
    },
    /// A string isn't UTF-8, or a wide one isn't UTF-16.
    NotUnicode,
    /// A string doesn't end with its NUL, or holds one before.
    Nul,
    /// A `bool` is neither 0 nor 1; refused in strict mode alone.
    Bool(u8),
    /// A payload goes on after the message and its alignment.
    Trailing(usize),
    /// The buffer to write to is too small.
    Buffer {
        /// Bytes that the message takes.
        needed: usize,
        /// Bytes that there is room for.
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
                    "expected {padded} bytes, or {no_padding} without the padding at the end, found {found}"
                )
            }
            Self::Truncated { needed, left } => {
                write!(formatter, "expected {needed} more bytes, found {left}")
            }
            Self::Encapsulation([first, second]) => write!(
                formatter,
                "expected a CDR payload that starts with 00 01 (little endian) or 00 00 (big endian), found {first:02x} \
                 {second:02x}"
            ),
            Self::TooLong { bound, found } => write!(formatter, "expected at most {bound}, found {found}"),
            Self::NotUnicode => formatter.write_str("expected a string in Unicode, found other bytes"),
            Self::Nul => formatter.write_str("expected one NUL in a string, at its end"),
            Self::Bool(byte) => write!(formatter, "expected a bool of 0 or 1, found {byte}"),
            Self::Trailing(count) => write!(formatter, "expected no more bytes, found {count}"),
            Self::Buffer { needed, room } => {
                write!(formatter, "expected room for {needed} bytes, found {room}")
            }
        }
    }
}

/// Why bytes are no message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecodeError {
    /// What is wrong.
    pub fault: Fault,
    /// Where in the bytes, from their start.
    pub offset: usize,
    /// Where in the message.
    pub path: Path,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} at byte {}: {}", self.path, self.offset, self.fault)
    }
}

/// Why a message can't be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodeError {
    /// What is wrong.
    pub fault: Fault,
    /// Where in the message.
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
