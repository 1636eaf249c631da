//! A chunk that is being filled.

use std::collections::BTreeMap;
use std::io::{self, Write};

use lz4_flex::frame::FrameEncoder;
use mcap::records::{MessageHeader, op};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::record::{bytes, record};
use crate::mcap::Packing;

/// The size of an index entry, in bytes.
const ENTRY: usize = 16;

/// The records of a chunk, with the index of its messages.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    pub(super) records: Vec<u8>,
    /// The compression.
    pub(super) packing: Option<Packing>,
    /// The first and the last log time.
    pub(super) times: Option<(u64, u64)>,
    /// The log time and the position of each message, by channel.
    entries: BTreeMap<u16, Vec<u8>>,
}

/// The indexes of the messages in a chunk.
pub(super) struct Indexes {
    /// The index records.
    pub(super) records: Vec<u8>,
    /// The channels. Each has the position of its index among the records, and the number of its messages.
    pub(super) channels: Vec<(u16, u64, u64)>,
}

impl Chunk {
    pub(super) fn message(&mut self, header: &MessageHeader, payload: &[u8]) {
        let MessageHeader { channel_id, sequence, log_time, publish_time } = *header;
        let (first, last) = self.times.unwrap_or((log_time, log_time));
        self.times = Some((first.min(log_time), last.max(log_time)));
        let entries = self.entries.entry(channel_id).or_default();
        entries.extend_from_slice(&log_time.to_le_bytes());
        entries.extend_from_slice(&(self.records.len() as u64).to_le_bytes());
        let mut head = [0; 31];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&(payload.len() as u64 + 22).to_le_bytes());
        head[9..11].copy_from_slice(&channel_id.to_le_bytes());
        head[11..15].copy_from_slice(&sequence.to_le_bytes());
        head[15..23].copy_from_slice(&log_time.to_le_bytes());
        head[23..31].copy_from_slice(&publish_time.to_le_bytes());
        self.records.extend_from_slice(&head);
        self.records.extend_from_slice(payload);
    }

    /// Removes and returns the indexes of the messages.
    pub(super) fn take_indexes(&mut self) -> Indexes {
        let mut indexes = Indexes { records: Vec::new(), channels: Vec::new() };
        for (channel, entries) in std::mem::take(&mut self.entries) {
            let count = (entries.len() / ENTRY) as u64;
            indexes.channels.push((channel, indexes.records.len() as u64, count));
            record(&mut indexes.records, op::MESSAGE_INDEX, |out| {
                out.extend_from_slice(&channel.to_le_bytes());
                bytes(out, &entries);
            });
        }
        indexes
    }
}

/// The name of a compression in the header of a chunk.
pub(super) fn name(packing: Option<Packing>) -> &'static str {
    match packing {
        None => "",
        Some(Packing::Zstd) => "zstd",
        Some(Packing::Lz4) => "lz4",
    }
}

/// Compresses the records of a chunk.
pub fn compressed(packing: Packing, records: &[u8]) -> io::Result<Vec<u8>> {
    match packing {
        Packing::Zstd => Ok(compress_to_vec(records, CompressionLevel::Fastest)),
        Packing::Lz4 => {
            let mut encoder = FrameEncoder::new(Vec::new());
            encoder.write_all(records)?;
            encoder.finish().map_err(io::Error::other)
        }
    }
}
