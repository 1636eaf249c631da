//! Writes MCAP files, including invalid ones.

use std::io::Write as _;

use lz4_flex::frame::FrameEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

/// The bytes at the start and at the end of a file.
pub const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A record with its kind, length and content.
pub fn record(opcode: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

/// A string with its length.
pub fn text(text: &[u8]) -> Vec<u8> {
    [&u32::try_from(text.len()).expect("a length").to_le_bytes()[..], text].concat()
}

/// The header record.
pub fn header(profile: &str) -> Vec<u8> {
    record(1, &[&text(profile.as_bytes()), &text(b"glider club")])
}

/// A schema record.
pub fn schema(id: u16, name: &str, encoding: &str, data: &[u8]) -> Vec<u8> {
    record(3, &[&id.to_le_bytes(), &text(name.as_bytes()), &text(encoding.as_bytes()), &text(data)])
}

/// A channel record.
pub fn channel(id: u16, schema: u16, topic: &str, encoding: &str, metadata: &[(&str, &str)]) -> Vec<u8> {
    let pairs = metadata.iter().flat_map(|(key, value)| [text(key.as_bytes()), text(value.as_bytes())]);
    let pairs: Vec<Vec<u8>> = pairs.collect();
    let names = [text(topic.as_bytes()), text(encoding.as_bytes()), text(&pairs.concat())].concat();
    record(4, &[&id.to_le_bytes(), &schema.to_le_bytes(), &names])
}

/// A message record without times.
pub fn message(channel: u16, payload: &[u8]) -> Vec<u8> {
    message_at(channel, 7, payload)
}

/// A message with this log time in ns.
pub fn message_at(channel: u16, time: u64, payload: &[u8]) -> Vec<u8> {
    let time = time.to_le_bytes();
    record(5, &[&channel.to_le_bytes(), &[0; 4], &time, &time, payload])
}

/// The storage of records in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Records outside of chunks.
    Unchunked,
    /// A chunk that is not compressed.
    Plain,
    /// A chunk in zstd.
    Zstd,
    /// A chunk in LZ4.
    Lz4,
}

/// All forms.
pub const FORMS: [Form; 4] = [Form::Unchunked, Form::Plain, Form::Zstd, Form::Lz4];

/// Writes records in this form. Each element of `chunks` contains the records of one chunk.
pub fn chunked(form: Form, chunks: &[Vec<u8>]) -> Vec<u8> {
    let stored =
        |records: &Vec<u8>| if form == Form::Unchunked { records.clone() } else { chunk(form, records) };
    chunks.iter().map(stored).collect::<Vec<_>>().concat()
}

/// A chunk with these records.
pub fn chunk(form: Form, records: &[u8]) -> Vec<u8> {
    let (name, packed) = match form {
        Form::Unchunked | Form::Plain => ("", records.to_vec()),
        Form::Zstd => ("zstd", compress_to_vec(records, CompressionLevel::Fastest)),
        Form::Lz4 => {
            let mut encoder = FrameEncoder::new(Vec::new());
            encoder.write_all(records).expect("memory");
            ("lz4", encoder.finish().expect("memory"))
        }
    };
    raw_chunk(name, records.len() as u64, crc32fast::hash(records), packed.len() as u64, &packed)
}

/// A chunk with these values, which may be wrong.
pub fn raw_chunk(packing: &str, size: u64, checksum: u32, packed_size: u64, packed: &[u8]) -> Vec<u8> {
    let head = [&[0; 16][..], &size.to_le_bytes(), &checksum.to_le_bytes()].concat();
    record(6, &[&head, &text(packing.as_bytes()), &packed_size.to_le_bytes(), packed])
}

/// A complete file with these records.
pub fn file(records: &[u8]) -> Vec<u8> {
    [start(), records.to_vec(), end()].concat()
}

/// The start of a file.
pub fn start() -> Vec<u8> {
    [MAGIC.to_vec(), header("ros2")].concat()
}

/// The end of a file.
pub fn end() -> Vec<u8> {
    [record(15, &[&[0; 4]]), record(2, &[&[0; 20]]), MAGIC.to_vec()].concat()
}
