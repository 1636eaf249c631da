//! Reads MCAP, the container of ROS 2 and of Foxglove: <https://mcap.dev/spec>.
//!
//! A [`Reader`] goes through a file once, from its start, and lends the records that say what messages are and
//! the messages themselves. It needs no index and goes nowhere back, so it reads from a pipe, too.
//!
//! # What the crate `mcap` does here, and what not
//!
//! It reads what is within a record ([`mcap::parse_record`]). Its readers of whole files are not used:
//!
//! - They end at the first broken record, and say neither where it is nor where the next one may be found.
//! - They unpack chunks with C, or not at all.
//! - A record in a chunk that is longer than its chunk makes them count below zero, and an attachment that is too
//!   short makes them panic (0.26.0). So no attachment is given to them, and nothing of which the lengths don't
//!   agree with each other.
//!
//! So what stands around records is read here, and chunks are unpacked by `ruzstd` and `lz4_flex`.
//!
//! # Memory
//!
//! Chunks that aren't packed are read record by record, however long they are. Of one that is packed, the packed
//! bytes are held (at most [`Reader::MAX_PACKED`]), and unpacked as they are read. A record that is lent is held
//! whole (at most [`Reader::MAX_RECORD`]), all others are passed over. Room is only taken for bytes that
//! are really there, whatever lengths say.
//!
//! # How damage is survived
//!
//! What a record says of its lengths has to agree with its kind, and something that can be a record has to follow it.
//! Where this fails, the next record is searched that is sound: a chunk whose lengths agree, a message of a declared
//! channel that is followed by a record, a schema, a channel or an index whose parts are as long as the whole. What
//! lies between is told with its place and its length.
//!
//! A chunk that is broken within is left, and what stands before the breakage was lent. Whether the CRC of a chunk
//! is right is known only at its end; if it isn't, that is told, and its records have been lent by then.

mod chunk;
mod problem;
mod reader;
mod sound;
mod unpack;
mod window;

use std::collections::BTreeMap;

pub(crate) use self::problem::Problem;
pub(crate) use self::reader::Reader;

/// What a file begins and ends with.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Something that a reader met.
#[derive(Debug)]
pub(crate) struct Item<'r> {
    /// Where it stands in the file; of what stands in a packed chunk, where the chunk stands.
    pub offset: u64,
    /// What it is.
    pub event: Event<'r>,
}

/// What a reader meets.
#[derive(Debug)]
pub(crate) enum Event<'r> {
    /// The header of the file.
    Header {
        /// What else holds of the file, such as `ros2`.
        profile: String,
        /// What wrote it.
        library: String,
    },
    /// A schema of messages.
    Schema {
        /// Its id, from 1.
        id: u16,
        /// Its name.
        name: String,
        /// In what it is written, such as `ros2msg`.
        encoding: String,
        /// Its text.
        text: &'r [u8],
    },
    /// A channel is declared.
    Channel {
        /// Its id.
        id: u16,
        /// The id of its schema; 0 where it has none.
        schema: u16,
        /// Its topic.
        topic: String,
        /// How its messages are written, such as `cdr`.
        encoding: String,
        /// What else is said of it.
        metadata: BTreeMap<String, String>,
    },
    /// A message.
    Message {
        /// The id of its channel.
        channel: u16,
        /// Its bytes.
        payload: &'r [u8],
    },
    /// Something can't be read.
    Problem(Problem),
}
