//! Writes MCAP files.
//!
//! The writer of the `mcap` crate compresses chunks only with C libraries, and needs more time and memory.

mod chunk;
mod record;

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use crc32fast::Hasher;
use mcap::records::{MessageHeader, op};
use uavspec_schema::event::is_compressed;

use self::chunk::Chunk;
pub use self::chunk::compressed;
use self::record::{bytes, prefixed, record, text, texts};
use super::{AttachmentHead, EVENT_METADATA, LIBRARY, MAGIC, Packing};

/// The size of a chunk, in bytes. With larger chunks, the summary is smaller, but readers need more memory.
const CHUNK_SIZE: usize = 4 << 20;

/// The size of the buffer for copied attachments, in bytes. It contains the head of each attachment.
const BUFFER: usize = 128 << 10;

/// The body of a metadata record.
pub fn metadata_body(name: &str, values: &BTreeMap<String, String>) -> Vec<u8> {
    let mut body = Vec::new();
    text(&mut body, name);
    texts(&mut body, values);
    body
}

/// The body of an attachment without times.
pub fn attachment_body(name: &str, media_type: &str, data: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 16];
    text(&mut body, name);
    text(&mut body, media_type);
    prefixed::<8>(&mut body, |body| body.extend_from_slice(data));
    let checksum = crc32fast::hash(&body);
    body.extend_from_slice(&checksum.to_le_bytes());
    body
}

/// Writes a file from start to end, including all indexes.
pub struct Writer<W> {
    output: W,
    /// The number of bytes written.
    position: u64,
    checksum: Hasher,
    chunk: Chunk,
    summary: Summary,
}

/// The records of the summary, encoded.
#[derive(Default)]
struct Summary {
    schemas: Vec<u8>,
    channels: Vec<u8>,
    chunks: Vec<u8>,
    attachments: Vec<u8>,
    metadata: Vec<u8>,
    counts: Counts,
    times: Option<(u64, u64)>,
}

/// The numbers of records.
#[derive(Default)]
struct Counts {
    schemas: u16,
    channels: u32,
    chunks: u32,
    attachments: u32,
    metadata: u32,
    /// The number of messages of each channel.
    messages: BTreeMap<u16, u64>,
}

impl<W: Write> Writer<W> {
    /// Writes the start of a file.
    pub fn new(output: W, profile: &str) -> io::Result<Self> {
        let (chunk, summary) = (Chunk::default(), Summary::default());
        let mut writer = Self { output, position: 0, checksum: Hasher::new(), chunk, summary };
        let mut start = MAGIC.to_vec();
        record(&mut start, op::HEADER, |out| {
            text(out, profile);
            text(out, &format!("{LIBRARY}{}", env!("CARGO_PKG_VERSION")));
        });
        writer.put(&start)?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.checksum.update(bytes);
        self.position += bytes.len() as u64;
        self.output.write_all(bytes)
    }

    /// Sets the compression of the following records in chunks.
    pub fn set_packing(&mut self, packing: Option<Packing>) -> io::Result<()> {
        if self.chunk.packing != packing {
            self.close_chunk()?;
            self.chunk.packing = packing;
        }
        Ok(())
    }

    /// Writes a schema.
    pub fn schema(&mut self, id: u16, (name, encoding): (&str, &str), content: &[u8]) -> io::Result<()> {
        let start = self.chunk.records.len();
        record(&mut self.chunk.records, op::SCHEMA, |out| {
            out.extend_from_slice(&id.to_le_bytes());
            text(out, name);
            text(out, encoding);
            bytes(out, content);
        });
        self.summary.schemas.extend_from_slice(&self.chunk.records[start..]);
        self.summary.counts.schemas += 1;
        self.close_full_chunk()
    }

    /// Writes a channel.
    pub fn channel(
        &mut self,
        (id, schema): (u16, u16),
        (topic, encoding): (&str, &str),
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        let start = self.chunk.records.len();
        record(&mut self.chunk.records, op::CHANNEL, |out| {
            out.extend_from_slice(&id.to_le_bytes());
            out.extend_from_slice(&schema.to_le_bytes());
            text(out, topic);
            text(out, encoding);
            texts(out, metadata);
        });
        self.summary.channels.extend_from_slice(&self.chunk.records[start..]);
        self.summary.counts.channels += 1;
        self.close_full_chunk()
    }

    /// Writes a message.
    pub fn message(&mut self, header: &MessageHeader, payload: &[u8]) -> io::Result<()> {
        self.chunk.message(header, payload);
        self.close_full_chunk()
    }

    /// Copies a record of an application.
    pub fn private(&mut self, opcode: u8, body: &[u8], is_in_chunk: bool) -> io::Result<()> {
        if is_in_chunk {
            record(&mut self.chunk.records, opcode, |out| out.extend_from_slice(body));
            return self.close_full_chunk();
        }
        self.top_level(opcode, body).map(drop)
    }

    /// Copies a metadata record.
    pub fn metadata(&mut self, body: &[u8]) -> io::Result<()> {
        let name = body.first_chunk().map_or(0, |length| u32::from_le_bytes(*length) as usize);
        let name = body.get(..name.saturating_add(4)).unwrap_or_default();
        let (offset, length) = self.top_level(op::METADATA, body)?;
        record(&mut self.summary.metadata, op::METADATA_INDEX, |out| {
            out.extend_from_slice(&offset.to_le_bytes());
            out.extend_from_slice(&length.to_le_bytes());
            out.extend_from_slice(name);
        });
        self.summary.counts.metadata += 1;
        Ok(())
    }

    /// Copies an attachment of `length` bytes.
    pub fn attachment(&mut self, length: u64, body: &mut dyn Read) -> io::Result<()> {
        self.close_chunk()?;
        let (offset, mut left) = (self.position, length);
        let mut buffer = Vec::with_capacity(BUFFER);
        body.take(BUFFER as u64).read_to_end(&mut buffer)?;
        if let Some(head) = AttachmentHead::read(&buffer) {
            record(&mut self.summary.attachments, op::ATTACHMENT_INDEX, |out| {
                out.extend_from_slice(&offset.to_le_bytes());
                out.extend_from_slice(&(length + 9).to_le_bytes());
                out.extend_from_slice(head.times);
                out.extend_from_slice(&head.size.to_le_bytes());
                out.extend_from_slice(head.name);
                out.extend_from_slice(head.media_type);
            });
        }
        self.summary.counts.attachments += 1;
        self.put(&[op::ATTACHMENT])?;
        self.put(&length.to_le_bytes())?;
        while !buffer.is_empty() {
            self.put(&buffer)?;
            left = left.saturating_sub(buffer.len() as u64);
            buffer.clear();
            body.take(left.min(BUFFER as u64)).read_to_end(&mut buffer)?;
        }
        Ok(())
    }

    /// Writes the event metadata of a vehicle as an attachment: JSON, which may be compressed with xz.
    pub fn event_metadata(&mut self, file: &[u8]) -> io::Result<()> {
        let [json, xz] = EVENT_METADATA;
        let (name, media_type) =
            if is_compressed(file) { (xz, "application/x-xz") } else { (json, "application/json") };
        let body = attachment_body(name, media_type, file);
        self.attachment(body.len() as u64, &mut &body[..])
    }

    /// Writes a record outside of chunks. Returns its offset and its length.
    fn top_level(&mut self, opcode: u8, body: &[u8]) -> io::Result<(u64, u64)> {
        self.close_chunk()?;
        let offset = self.position;
        self.put(&[opcode])?;
        self.put(&(body.len() as u64).to_le_bytes())?;
        self.put(body)?;
        Ok((offset, self.position - offset))
    }

    /// Writes all records that have been added so far to the output.
    pub fn flush(&mut self) -> io::Result<()> {
        self.close_chunk()?;
        self.output.flush()
    }

    fn close_full_chunk(&mut self) -> io::Result<()> {
        if self.chunk.records.len() >= CHUNK_SIZE { self.close_chunk() } else { Ok(()) }
    }

    fn close_chunk(&mut self) -> io::Result<()> {
        if self.chunk.records.is_empty() {
            return Ok(());
        }
        let mut records = std::mem::take(&mut self.chunk.records);
        let packing = self.chunk.packing;
        let packed = packing.map(|packing| chunk::compressed(packing, &records)).transpose()?;
        let stored = packed.as_deref().unwrap_or(&records);
        let (first, last) = self.chunk.times.unwrap_or_default();
        let offset = self.position;
        let mut head = Vec::new();
        for number in [first, last, records.len() as u64] {
            head.extend_from_slice(&number.to_le_bytes());
        }
        head.extend_from_slice(&crc32fast::hash(&records).to_le_bytes());
        text(&mut head, chunk::name(packing));
        head.extend_from_slice(&(stored.len() as u64).to_le_bytes());
        self.put(&[op::CHUNK])?;
        self.put(&((head.len() + stored.len()) as u64).to_le_bytes())?;
        self.put(&head)?;
        self.put(stored)?;
        self.index_chunk((offset, records.len(), stored.len()))?;
        records.clear();
        // Releases the memory of a large message.
        records.shrink_to(2 * CHUNK_SIZE);
        self.chunk.records = records;
        Ok(())
    }

    /// Writes the indexes of the messages in a chunk. `chunk` contains its offset, the size of its records, and their
    /// compressed size.
    fn index_chunk(&mut self, (offset, size, packed): (u64, usize, usize)) -> io::Result<()> {
        let start = self.position;
        let indexes = self.chunk.take_indexes();
        self.put(&indexes.records)?;
        let times = self.chunk.times.take();
        let (first, last) = times.unwrap_or_default();
        if times.is_some() {
            let (start, end) = self.summary.times.unwrap_or((first, last));
            self.summary.times = Some((start.min(first), end.max(last)));
        }
        record(&mut self.summary.chunks, op::CHUNK_INDEX, |out| {
            for number in [first, last, offset, start - offset] {
                out.extend_from_slice(&number.to_le_bytes());
            }
            prefixed::<4>(out, |out| {
                for (channel, at, _) in &indexes.channels {
                    out.extend_from_slice(&channel.to_le_bytes());
                    out.extend_from_slice(&(start + at).to_le_bytes());
                }
            });
            out.extend_from_slice(&(indexes.records.len() as u64).to_le_bytes());
            text(out, chunk::name(self.chunk.packing));
            out.extend_from_slice(&(packed as u64).to_le_bytes());
            out.extend_from_slice(&(size as u64).to_le_bytes());
        });
        self.summary.counts.chunks += 1;
        for (channel, _, count) in indexes.channels {
            *self.summary.counts.messages.entry(channel).or_default() += count;
        }
        Ok(())
    }

    /// The number of bytes written so far.
    pub fn size(&self) -> u64 {
        self.position
    }

    /// Writes the summary and the end of the file. Returns the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.close_chunk()?;
        let mut end = Vec::new();
        let checksum = self.checksum.clone().finalize();
        record(&mut end, op::DATA_END, |out| out.extend_from_slice(&checksum.to_le_bytes()));
        self.put(&end)?;
        let start = self.position;
        self.checksum = Hasher::new();
        let summary = std::mem::take(&mut self.summary);
        let mut offsets = Vec::new();
        for (opcode, records) in [
            (op::SCHEMA, &summary.schemas),
            (op::CHANNEL, &summary.channels),
            (op::STATISTICS, &summary.statistics()),
            (op::CHUNK_INDEX, &summary.chunks),
            (op::ATTACHMENT_INDEX, &summary.attachments),
            (op::METADATA_INDEX, &summary.metadata),
        ] {
            if records.is_empty() {
                continue;
            }
            record(&mut offsets, op::SUMMARY_OFFSET, |out| {
                out.push(opcode);
                out.extend_from_slice(&self.position.to_le_bytes());
                out.extend_from_slice(&(records.len() as u64).to_le_bytes());
            });
            self.put(records)?;
        }
        let offset_start = self.position;
        self.put(&offsets)?;
        // The checksum includes the first fields of the footer.
        self.put(&[op::FOOTER])?;
        self.put(&20_u64.to_le_bytes())?;
        self.put(&start.to_le_bytes())?;
        self.put(&offset_start.to_le_bytes())?;
        let checksum = self.checksum.clone().finalize();
        self.put(&checksum.to_le_bytes())?;
        self.put(&MAGIC)?;
        Ok(self.output)
    }
}

impl Summary {
    fn statistics(&self) -> Vec<u8> {
        let (counts, (first, last)) = (&self.counts, self.times.unwrap_or_default());
        let mut out = Vec::new();
        record(&mut out, op::STATISTICS, |out| {
            out.extend_from_slice(&counts.messages.values().sum::<u64>().to_le_bytes());
            out.extend_from_slice(&counts.schemas.to_le_bytes());
            for count in [counts.channels, counts.attachments, counts.metadata, counts.chunks] {
                out.extend_from_slice(&count.to_le_bytes());
            }
            out.extend_from_slice(&first.to_le_bytes());
            out.extend_from_slice(&last.to_le_bytes());
            prefixed::<4>(out, |out| {
                for (channel, count) in &counts.messages {
                    out.extend_from_slice(&channel.to_le_bytes());
                    out.extend_from_slice(&count.to_le_bytes());
                }
            });
        });
        out
    }
}
