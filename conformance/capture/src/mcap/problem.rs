//! Problems in an MCAP file.

use std::fmt;

use uavspec_model::Extent;
use uavspec_model::text::thousands;

/// A problem in an MCAP file, except in the content of messages.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The magic at the start is missing.
    NoMagic,
    /// The first record isn't the header.
    NoHeader,
    /// The file ends within a record.
    Truncated {
        /// The number of bytes that are missing from the record.
        missing: u64,
    },
    /// The footer and the magic at the end are missing.
    NoEnd,
    /// Data follows the closing magic bytes.
    AfterEnd {
        /// The number of bytes.
        length: u64,
    },
    /// There is no valid record at this offset, so the reader searched for the next valid record.
    Skipped {
        /// The reason why the bytes aren't a valid record.
        found: Malformed,
        /// The number of bytes before the next record or the end.
        length: u64,
    },
    /// A record with invalid content was skipped.
    Unreadable {
        /// The opcode.
        opcode: u8,
    },
    /// A record in a chunk exceeds the size limit and was skipped.
    TooLong {
        /// The opcode.
        opcode: u8,
        /// The stated length.
        length: u64,
    },
    /// A chunk has an unknown compression and was skipped.
    Packing {
        /// The name of the compression.
        name: String,
    },
    /// The rest of a chunk can't be decompressed.
    Unpack {
        /// The number of decompressed bytes.
        unpacked: u64,
        /// The error.
        error: String,
    },
    /// The size of a chunk differs from the size in its header.
    ChunkSize {
        /// The size in the header.
        stated: u64,
        /// The actual size, or a lower bound if `is_more` is true.
        found: u64,
        /// True if the actual size is larger than `found`.
        is_more: bool,
    },
    /// A chunk contains an invalid record.
    InChunk {
        /// The offset in the chunk.
        at: u64,
    },
    /// The checksum of a chunk is wrong.
    ChunkChecksum {
        /// The checksum in the header.
        stated: u32,
        /// The checksum of the records.
        found: u32,
    },
    /// The checksum of a part of the file is wrong.
    Checksum {
        /// The part.
        part: &'static str,
        /// The checksum in the file.
        stated: u32,
        /// The checksum of the bytes.
        found: u32,
    },
    /// A record of an unknown kind, or of a kind that isn't allowed in this part of the file.
    Misplaced {
        /// The opcode.
        opcode: u8,
    },
    /// The footer states a wrong offset for the summary.
    SummaryStart {
        /// The offset in the footer.
        stated: u64,
        /// The offset of the summary.
        found: u64,
    },
    /// A number in the statistics differs from the number of records in the file.
    Count {
        /// The kind of the records.
        noun: &'static str,
        /// The number in the statistics.
        stated: u64,
        /// The number of records.
        found: u64,
    },
    /// An index doesn't list the records in the file.
    Index {
        /// The kind of the records.
        noun: &'static str,
    },
}

/// The reason why there is no valid record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Malformed {
    /// The length is impossible for the opcode.
    Length {
        /// The opcode.
        opcode: u8,
        /// The stated length.
        length: u64,
    },
    /// The record is longer than the rest of the file.
    Beyond {
        /// The opcode.
        opcode: u8,
        /// The stated length.
        length: u64,
    },
    /// The parts of the record don't match its length.
    Parts {
        /// The opcode.
        opcode: u8,
    },
    /// No valid record follows.
    Follower {
        /// The opcode.
        opcode: u8,
    },
}

impl Problem {
    /// The extent to which the file can be read despite this problem.
    pub fn extent(&self) -> Extent {
        match self {
            Self::Truncated { .. } | Self::NoEnd => Extent::EndsEarly,
            _ => Extent::WithGaps,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMagic => formatter.write_str("the file doesn't start with the magic bytes of MCAP"),
            Self::NoHeader => formatter.write_str("the file doesn't start with a header record"),
            Self::Truncated { missing } => {
                write!(
                    formatter,
                    "the file is truncated within a record: {} bytes are missing",
                    thousands(missing)
                )
            }
            Self::NoEnd => formatter
                .write_str("the file ends without a footer: it is truncated, or its writer didn't finish"),
            Self::AfterEnd { length } => {
                write!(formatter, "{} bytes follow the closing magic bytes", thousands(length))
            }
            Self::Skipped { found, length } => {
                write!(formatter, "{found}; skipped {} bytes", thousands(length))
            }
            Self::Unreadable { opcode } => {
                write!(
                    formatter,
                    "{} is unreadable: it is too short, or contains invalid UTF-8 or a duplicate key",
                    Kind(*opcode)
                )
            }
            Self::TooLong { opcode, length } => {
                write!(
                    formatter,
                    "skipped {} of {} bytes, because it exceeds the limit",
                    Kind(*opcode),
                    thousands(length)
                )
            }
            Self::Packing { name } => write!(
                formatter,
                "a chunk uses the unknown compression `{}`: expected zstd, lz4 or none",
                name.escape_debug()
            ),
            Self::Unpack { unpacked, error } => {
                write!(
                    formatter,
                    "decompression of a chunk fails after {} bytes: {error}",
                    thousands(unpacked)
                )
            }
            Self::ChunkSize { stated, found, is_more } => write!(
                formatter,
                "a chunk contains {}{} bytes, but its header says {}",
                if *is_more { "more than " } else { "" },
                thousands(found),
                thousands(stated)
            ),
            Self::InChunk { at } => {
                write!(formatter, "a chunk has an invalid record after {} bytes", thousands(at))
            }
            Self::ChunkChecksum { stated, found } => write!(
                formatter,
                "a chunk has the checksum {found:08x}, but its header says {stated:08x}: its content was changed"
            ),
            Self::Checksum { part, stated, found } => write!(
                formatter,
                "the {part} has the checksum {found:08x}, but the file says {stated:08x}: its content was changed"
            ),
            Self::Misplaced { opcode } => {
                write!(formatter, "{} isn't expected in this part of the file", Kind(*opcode))
            }
            Self::SummaryStart { stated, found } => write!(
                formatter,
                "the summary starts at byte {}, but the footer says byte {}",
                thousands(found),
                thousands(stated)
            ),
            Self::Count { noun, stated, found } => write!(
                formatter,
                "the statistics of the file say {} {noun}, but the file contains {}",
                thousands(stated),
                thousands(found)
            ),
            Self::Index { noun } => write!(formatter, "the index doesn't match the {noun}"),
        }
    }
}

impl fmt::Display for Malformed {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { opcode, length } => {
                write!(formatter, "{} can't be {} bytes long", Kind(*opcode), thousands(length))
            }
            Self::Beyond { opcode, length } => {
                write!(
                    formatter,
                    "{} of {} bytes is longer than the rest of the file",
                    Kind(*opcode),
                    thousands(length)
                )
            }
            Self::Parts { opcode } => {
                write!(formatter, "the field lengths in {} don't match its length", Kind(*opcode))
            }
            Self::Follower { opcode } => {
                write!(formatter, "{} isn't followed by a valid record", Kind(*opcode))
            }
        }
    }
}

/// A record's opcode, displayed as the name of its kind.
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
            op::SUMMARY_OFFSET => "a summary offset",
            op::DATA_END => "an end-of-data record",
            opcode => return write!(formatter, "a record of unknown kind {opcode:#04x}"),
        })
    }
}
