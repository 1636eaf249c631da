//! Reads and writes MCAP, the container format of ROS 2 and Foxglove: <https://mcap.dev/spec>.
//!
//! A [`Reader`] reads a file once, from start to end, and returns its schemas, channels and messages. The reader uses
//! no index and never seeks, so it can also read from pipes.
//!
//! # Use of the `mcap` crate
//!
//! The crate parses single records ([`mcap::parse_record`]). The crate's file readers are not used, for these reasons:
//!
//! - They stop at the first invalid record, and report neither its offset nor the next valid record.
//! - In version 0.26.0, a record longer than its chunk causes an integer underflow, and an attachment that is too short
//!   causes a panic. Attachments, and records with contradictory lengths, are therefore never passed to the crate.
//!   Messages are not passed either, because most records are messages.
//!
//! This module parses the framing of records, and `zstd` or `ruzstd`, and `lz4_flex`, decompress chunks.
//!
//! # Statistics and indexes
//!
//! The reader uses neither, but compares them with the records that it read: a difference means that records are missing
//! or corrupt. It also verifies all checksums. Another file may follow the end of a file, as after `cat`. The reader
//! returns its records, too.
//!
//! # Memory
//!
//! An uncompressed chunk of any length is read record by record. A compressed chunk is buffered (at most `MAX_PACKED`) and
//! decompressed as it is read. Each returned record is buffered (at most [`MAX_RECORD`](crate::limits::MAX_RECORD)), except
//! attachments, which are returned in parts. All other records are skipped. Buffers grow with the data that is read, not
//! with the stated lengths.
//!
//! # Recovery from corruption
//!
//! The lengths in a record must match its kind, and plausible data must follow the record. Otherwise, the reader
//! searches for the next valid record. The search accepts a chunk if its lengths match, and a schema, channel or index
//! if its parts match its length. A message of a declared channel is also accepted if another record follows. The
//! skipped bytes are reported with their offset and length.
//!
//! The rest of a corrupt chunk is skipped. The records before the corruption are still returned. The CRC of a chunk can
//! only be verified at the end of the chunk. A mismatch is therefore reported after the chunk's records.

mod census;
mod chunk;
mod problem;
mod reader;
mod sound;
mod unpack;
mod window;
mod writer;

use std::collections::BTreeMap;

pub use self::problem::Problem;
pub use self::reader::Reader;
pub use self::sound::{AttachmentHead, metadata};
pub use self::unpack::Packing;
pub use self::writer::{Writer, attachment_body, compressed, metadata_body};

/// The name of the metadata records about the publishers and subscribers of a live vehicle.
/// [`Endpoint::to_values`](uavspec_model::Endpoint::to_values) returns the values. A record with only the id means that
/// the endpoint has ended.
pub const ENDPOINT: &str = "uavspec:endpoint";

/// The name of the metadata records about the definitions of an application.
/// [`ApplicationType::to_values`](uavspec_model::ApplicationType::to_values) returns the values.
pub const APPLICATION: &str = "uavspec:application";

/// The name of the metadata records about lost messages. Their keys are `topic` and `count`.
pub const LOST: &str = "uavspec:lost";

/// The name of the metadata records about data of a live vehicle that wasn't received or can't be read. Their only key
/// is `text`.
pub const UNREADABLE: &str = "uavspec:unreadable";

/// The name of the metadata records about notable events, such as invalid announcements. Their only key is `text`.
pub const NOTE: &str = "uavspec:note";

/// The name of the metadata record of a recording that was cut short. Its only key is `reason`.
pub const CUT_SHORT: &str = "uavspec:cut_short";

/// The names of attachments with the event metadata of the vehicle. PX4's build gives its files the same names.
pub const EVENT_METADATA: [&str; 2] = ["all_events.json", "all_events.json.xz"];

/// The metadata key of a channel whose messages were sent by this program. The value is `true`.
pub const OWN: &str = "uavspec:own";

/// The prefix of the library name in the headers of files that this program writes.
pub const LIBRARY: &str = "uavspec ";

/// The magic bytes at the start and at the end of a file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// A record or problem.
#[derive(Debug)]
pub struct Item<'r> {
    /// The offset in the file. For a record in a compressed chunk, this is the offset of the chunk.
    pub offset: u64,
    /// The compression of the chunk that contains the record; `None` outside of compressed chunks.
    pub packing: Option<Packing>,
    /// The content.
    pub event: Event<'r>,
}

/// The content of an item.
#[derive(Debug)]
pub enum Event<'r> {
    /// The header of the file.
    Header {
        /// The profile, e.g. `ros2`.
        profile: String,
        /// The library that wrote the file.
        library: String,
    },
    /// A schema for messages.
    Schema {
        /// The id, from 1.
        id: u16,
        /// The name.
        name: String,
        /// The encoding, e.g. `ros2msg`.
        encoding: String,
        /// The text.
        text: &'r [u8],
    },
    /// The declaration of a channel.
    Channel {
        /// The id.
        id: u16,
        /// The id of the schema; 0 if there is none.
        schema: u16,
        /// The topic.
        topic: String,
        /// The encoding of messages, e.g. `cdr`.
        encoding: String,
        /// The metadata.
        metadata: BTreeMap<String, String>,
    },
    /// A message.
    Message {
        /// The id of the channel.
        channel: u16,
        /// The log time, in ns.
        time: u64,
        /// The publish time, in ns.
        publish_time: u64,
        /// The sequence number.
        sequence: u32,
        /// The bytes.
        payload: &'r [u8],
    },
    /// A part of an attachment. The parts follow each other without gaps. If the file is truncated, the last part is
    /// missing.
    Attachment {
        /// The length of the record's body.
        length: u64,
        /// The position of this part in the body. The first part contains the head of the attachment.
        at: u64,
        /// The bytes.
        bytes: &'r [u8],
    },
    /// A metadata record.
    Metadata {
        /// The body of the record.
        body: &'r [u8],
    },
    /// A record of an application. The specification reserves opcodes for such records.
    Private {
        /// The opcode.
        opcode: u8,
        /// The body of the record.
        body: &'r [u8],
        /// True if the record is in a chunk.
        is_in_chunk: bool,
    },
    /// A problem.
    Problem(Problem),
}
