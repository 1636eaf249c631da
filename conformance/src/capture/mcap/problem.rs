//! What can't be read.

use std::fmt;

use crate::model::Extent;
use crate::text::Grouped;

/// What is wrong with a file, beside what its messages say.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub(crate) enum Problem {
    /// It doesn't begin with the magic.
    NoMagic,
    /// Another record than its header comes first.
    NoHeader,
    /// It ends within a record.
    Truncated {
        /// How many bytes the record still claims.
        missing: u64,
    },
    /// It ends without its footer and the magic behind it.
    NoEnd,
    /// Something follows its end.
    AfterEnd {
        /// How many bytes.
        length: u64,
    },
    /// No record begins here; the next one that is sound was searched.
    Skipped {
        /// What stands here instead.
        found: Malformed,
        /// How many bytes lie before the next record, or the end.
        length: u64,
    },
    /// A record can't be read, and was passed over.
    Unreadable {
        /// Its opcode.
        opcode: u8,
    },
    /// A record in a chunk is longer than a reader holds, and was passed over.
    TooLong {
        /// Its opcode.
        opcode: u8,
        /// How long it says that it is.
        length: u64,
    },
    /// A chunk is packed in a way that isn't known; it was passed over.
    Packing {
        /// Its name.
        name: String,
    },
    /// A chunk can't be unpacked any further.
    Unpack {
        /// How many bytes came out of it.
        unpacked: u64,
        /// What is wrong.
        error: String,
    },
    /// A chunk doesn't hold as many bytes as its header says.
    ChunkSize {
        /// How many its header says.
        stated: u64,
        /// How many there are; at least so many where `is_more`.
        found: u64,
        /// Whether there are more than stated.
        is_more: bool,
    },
    /// A record in a chunk claims more than is left of the chunk, or no record is there.
    InChunk {
        /// How many bytes of the chunk lie before it.
        at: u64,
    },
    /// The checksum of a chunk isn't that of its records.
    ChunkChecksum {
        /// What its header says.
        stated: u32,
        /// That of its records.
        found: u32,
    },
    /// The checksum of all up to the end of the data isn't that of the bytes.
    DataChecksum {
        /// What the file says.
        stated: u32,
        /// That of the bytes.
        found: u32,
    },
}

/// What stands where a record should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Malformed {
    /// A record with an opcode and a length that don't go together.
    Length {
        /// Its opcode.
        opcode: u8,
        /// How long it says that it is.
        length: u64,
    },
    /// A record that is longer than what is left.
    Beyond {
        /// Its opcode.
        opcode: u8,
        /// How long it says that it is.
        length: u64,
    },
    /// A record whose parts don't agree with its length.
    Parts {
        /// Its opcode.
        opcode: u8,
    },
    /// A record that nothing sound follows.
    Follower {
        /// Its opcode.
        opcode: u8,
    },
}

impl Problem {
    /// How much of the file can be read that has it.
    pub(crate) fn extent(&self) -> Extent {
        match self {
            Self::Truncated { .. } | Self::NoEnd => Extent::EndsEarly,
            Self::NoHeader
            | Self::AfterEnd { .. }
            | Self::ChunkSize { .. }
            | Self::ChunkChecksum { .. }
            | Self::DataChecksum { .. } => Extent::Whole,
            Self::NoMagic
            | Self::Skipped { .. }
            | Self::Unreadable { .. }
            | Self::TooLong { .. }
            | Self::Packing { .. }
            | Self::Unpack { .. }
            | Self::InChunk { .. } => Extent::WithGaps,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMagic => formatter.write_str("the file doesn't begin as MCAP does"),
            Self::NoHeader => formatter.write_str("the file has no header at its start"),
            Self::Truncated { missing } => {
                write!(formatter, "the file ends within a record, {} bytes too early", Grouped(*missing))
            }
            Self::NoEnd => formatter
                .write_str("the file ends without a footer: it was cut off, or what wrote it didn't finish"),
            Self::AfterEnd { length } => {
                write!(formatter, "{} bytes follow the end of the file", Grouped(*length))
            }
            Self::Skipped { found, length } => {
                write!(formatter, "{found}; {} bytes passed over", Grouped(*length))
            }
            Self::Unreadable { opcode } => write!(
                formatter,
                "{} that can't be read: a text in it is no UTF-8, or a key is there twice",
                Kind(*opcode)
            ),
            Self::TooLong { opcode, length } => {
                write!(formatter, "{} of {} bytes, passed over", Kind(*opcode), Grouped(*length))
            }
            Self::Packing { name } => write!(
                formatter,
                "a chunk packed with `{}`, where zstd, lz4 or nothing are known",
                name.escape_debug()
            ),
            Self::Unpack { unpacked, error } => {
                write!(
                    formatter,
                    "a chunk that can't be unpacked after {} bytes: {error}",
                    Grouped(*unpacked)
                )
            }
            Self::ChunkSize { stated, found, is_more } => write!(
                formatter,
                "a chunk with {}{} bytes, where its header says {}",
                if *is_more { "more than " } else { "" },
                Grouped(*found),
                Grouped(*stated)
            ),
            Self::InChunk { at } => {
                write!(formatter, "a chunk in which no record begins after {} bytes", Grouped(*at))
            }
            Self::ChunkChecksum { stated, found } => write!(
                formatter,
                "a chunk with the checksum {found:08x}, where its header says {stated:08x}: what it holds was changed"
            ),
            Self::DataChecksum { stated, found } => write!(
                formatter,
                "data with the checksum {found:08x}, where the file says {stated:08x}: something before was changed"
            ),
        }
    }
}

impl fmt::Display for Malformed {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { opcode, length } => {
                write!(formatter, "{} can't have {} bytes", Kind(*opcode), Grouped(*length))
            }
            Self::Beyond { opcode, length } => {
                write!(formatter, "{} of {} bytes, more than are left", Kind(*opcode), Grouped(*length))
            }
            Self::Parts { opcode } => {
                write!(formatter, "{} whose parts don't agree with its length", Kind(*opcode))
            }
            Self::Follower { opcode } => {
                write!(formatter, "{} that no record follows where its length ends", Kind(*opcode))
            }
        }
    }
}

/// A kind of records, in words.
struct Kind(u8);

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        use mcap::records::op;
        formatter.write_str(match self.0 {
            op::HEADER => "a header",
            op::FOOTER => "a footer",
            op::SCHEMA => "a schema",
            op::CHANNEL => "a channel",
            op::MESSAGE => "a message",
            op::CHUNK => "a chunk",
            op::MESSAGE_INDEX | op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX => "an index",
            op::ATTACHMENT => "an attachment",
            op::STATISTICS => "statistics",
            op::METADATA => "metadata",
            op::SUMMARY_OFFSET => "an offset of the summary",
            op::DATA_END => "an end of data",
            opcode => return write!(formatter, "a record of the unknown kind {opcode:#04x}"),
        })
    }
}
