//! Compares the statistics and indexes of a file with the records that were read.

use std::collections::BTreeSet;

use mcap::records::{Record, Statistics, op};

use super::Problem;
use super::sound::Parts;

/// A set of items. Only their number and a checksum are stored. The order of the items doesn't matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    count: u64,
    sum: u64,
}

impl Tally {
    fn add(&mut self, item: impl IntoIterator<Item = u64>) {
        self.count += 1;
        self.sum = self.sum.wrapping_add(item.into_iter().fold(0, |hash, number| mixed(hash ^ number)));
    }
}

/// Distributes the differences between numbers over all bits: the last step of `SplitMix64`.
const fn mixed(number: u64) -> u64 {
    let number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}

/// The items of one kind that a file contains, and the items of this kind that its index lists.
#[derive(Clone, Copy, Debug, Default)]
struct Indexed {
    found: Tally,
    listed: Tally,
}

/// The ids of declared schemas or channels.
#[derive(Debug, Default)]
pub(super) struct Ids {
    /// The ids in the data section.
    in_data: BTreeSet<u16>,
    /// The ids in the whole file.
    all: BTreeSet<u16>,
}

impl Ids {
    pub(super) fn add(&mut self, id: u16, is_in_summary: bool) {
        if !is_in_summary {
            self.in_data.insert(id);
        }
        self.all.insert(id);
    }
}

/// The records of a file, and the statistics and indexes that describe them.
#[derive(Debug, Default)]
pub(super) struct Census {
    pub(super) schemas: Ids,
    pub(super) channels: Ids,
    /// The number of messages of each channel, by id.
    messages: Vec<u64>,
    /// The chunks, each with its offset, its length and its sizes.
    chunks: Indexed,
    attachments: Indexed,
    metadata: Indexed,
    /// The offset of the latest chunk.
    chunk: u64,
    /// The messages in the latest chunk, and in the message indexes after it: their channels and log times.
    in_chunk: Indexed,
    /// The statistics of the file.
    statistics: Option<Statistics>,
}

impl Census {
    /// True if a channel with this id was declared.
    pub(super) fn has_channel(&self, id: u16) -> bool {
        self.channels.all.contains(&id)
    }

    pub(super) fn message(&mut self, channel: u16, time: u64, is_in_chunk: bool) {
        let id = usize::from(channel);
        if id >= self.messages.len() {
            self.messages.resize(id + 1, 0);
        }
        self.messages[id] += 1;
        if is_in_chunk {
            self.in_chunk.found.add([channel.into(), time]);
        }
    }

    /// Adds a chunk: its offset, its length, the size of its records, and their compressed size. If the message indexes
    /// of the previous chunk are wrong, returns the offset of that chunk and the problem.
    pub(super) fn chunk(&mut self, facts: [u64; 4]) -> Option<(u64, Problem)> {
        let problem = self.close_chunk();
        self.chunk = facts[0];
        self.chunks.found.add(facts);
        problem
    }

    /// Compares the latest chunk with the indexes after it. Returns the offset of the chunk and the problem.
    pub(super) fn close_chunk(&mut self) -> Option<(u64, Problem)> {
        let Indexed { found, listed } = std::mem::take(&mut self.in_chunk);
        let is_wrong = listed.count > 0 && listed != found;
        is_wrong.then_some((self.chunk, Problem::Index { noun: "messages in a chunk" }))
    }

    pub(super) fn attachment(&mut self, offset: u64, length: u64) {
        self.attachments.found.add([offset, length]);
    }

    /// Counts a record, or stores the index or the statistics that it contains. Returns a problem if its content is
    /// invalid.
    pub(super) fn record(&mut self, opcode: u8, offset: u64, length: u64, body: &[u8]) -> Option<Problem> {
        let is_read = match opcode {
            op::METADATA => {
                self.metadata.found.add([offset, length]);
                Some(())
            }
            op::MESSAGE_INDEX => self.message_index(body),
            op::CHUNK_INDEX => chunk_index(body).map(|facts| self.chunks.listed.add(facts)),
            op::ATTACHMENT_INDEX => place(body).map(|place| self.attachments.listed.add(place)),
            op::METADATA_INDEX => place(body).map(|place| self.metadata.listed.add(place)),
            op::STATISTICS => statistics(body).map(|found| self.statistics = Some(found)),
            _ => Some(()),
        };
        is_read.is_none().then_some(Problem::Unreadable { opcode })
    }

    fn message_index(&mut self, body: &[u8]) -> Option<()> {
        let mut parts = Parts(body);
        let channel = parts.u16()?;
        let length = parts.u32()?;
        let mut entries = Parts(parts.take(length as usize)?);
        while !entries.0.is_empty() {
            self.in_chunk.listed.add([channel.into(), entries.u64()?]);
            entries.u64()?;
        }
        Some(())
    }

    /// The differences between the file's statistics and indexes and the records that were read.
    pub(super) fn differences(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        for (noun, Indexed { found, listed }) in
            [("chunks", self.chunks), ("attachments", self.attachments), ("metadata records", self.metadata)]
        {
            if listed.count > 0 && listed != found {
                problems.push(Problem::Index { noun });
            }
        }
        if let Some(statistics) = &self.statistics {
            problems.extend(self.wrong_counts(statistics));
        }
        problems
    }

    fn wrong_counts(&self, statistics: &Statistics) -> impl Iterator<Item = Problem> {
        let declared = |stated: u64, ids: &Ids| {
            // Writers differ in whether they count declarations that only the summary contains.
            let (min, max) = (ids.in_data.len() as u64, ids.all.len() as u64);
            (stated, stated.clamp(min, max))
        };
        let counts = [
            ("messages", (statistics.message_count, self.messages.iter().sum())),
            ("schemas", declared(statistics.schema_count.into(), &self.schemas)),
            ("channels", declared(statistics.channel_count.into(), &self.channels)),
            ("attachments", (statistics.attachment_count.into(), self.attachments.found.count)),
            ("metadata records", (statistics.metadata_count.into(), self.metadata.found.count)),
            ("chunks", (statistics.chunk_count.into(), self.chunks.found.count)),
        ];
        // Some writers list no channels.
        let of_channels = statistics.channel_message_counts.iter().map(|(channel, stated)| {
            (
                "messages of a channel",
                (*stated, self.messages.get(usize::from(*channel)).copied().unwrap_or_default()),
            )
        });
        let all: Vec<_> = counts.into_iter().chain(of_channels).collect();
        all.into_iter()
            .filter(|(_, (stated, found))| stated != found)
            .map(|(noun, (stated, found))| Problem::Count { noun, stated, found })
    }
}

/// The offset and the length of a record in an index.
fn place(body: &[u8]) -> Option<[u64; 2]> {
    let mut parts = Parts(body);
    Some([parts.u64()?, parts.u64()?])
}

/// Parses a chunk index. Returns the chunk's offset, its length, the size of its records, and their compressed size.
fn chunk_index(body: &[u8]) -> Option<[u64; 4]> {
    let mut parts = Parts(body);
    parts.take(16)?;
    let (offset, length) = (parts.u64()?, parts.u64()?);
    parts.text()?;
    parts.u64()?;
    parts.text()?;
    let (packed, size) = (parts.u64()?, parts.u64()?);
    Some([offset, length, size, packed])
}

/// Parses a statistics record, which contains the numbers of records.
fn statistics(body: &[u8]) -> Option<Statistics> {
    match mcap::parse_record(op::STATISTICS, body) {
        Ok(Record::Statistics(found)) => Some(found),
        _ => None,
    }
}
