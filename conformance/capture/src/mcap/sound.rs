//! Checks whether bytes may be a record, based on the lengths in them.

use std::collections::BTreeMap;

use mcap::records::{Metadata, Record, op};

use super::{Event, MAGIC};
use crate::limits::{MAX_ADDED, MAX_PACKING, MAX_RECORD};

/// The size of a record header: an opcode and a length.
pub(super) const HEAD: usize = 9;

/// The sizes of the fixed parts of a chunk, before and after the compression name.
const CHUNK_FIXED: (usize, usize) = (28, 8);

/// The size in bytes of the fixed part of a message, which precedes the payload.
const MESSAGE_FIXED: u64 = 22;

/// The size of the known fields of the footer, in bytes.
const FOOTER: u64 = 20;

/// The size of the known fields of an end-of-data record, in bytes.
const DATA_END: u64 = 4;

/// The first opcode for the records of applications.
const PRIVATE: u8 = 0x80;

/// The opcode and the length of a record.
pub(super) fn head(ahead: &[u8]) -> Option<(u8, u64)> {
    let (opcode, rest) = ahead.split_first()?;
    Some((*opcode, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// True if a record with this opcode can have this length.
pub(super) fn can_be(opcode: u8, length: u64) -> bool {
    match opcode {
        0 => false,
        op::FOOTER => (FOOTER..=FOOTER + MAX_ADDED).contains(&length),
        op::DATA_END => (DATA_END..=DATA_END + MAX_ADDED).contains(&length),
        op::MESSAGE => (MESSAGE_FIXED..=MAX_RECORD).contains(&length),
        // Chunks and attachments are read in parts, or skipped.
        op::CHUNK | op::ATTACHMENT => length <= u64::MAX >> 1,
        _ => length <= MAX_RECORD,
    }
}

/// The header of a chunk.
#[derive(Debug)]
pub(super) struct ChunkHead {
    /// The decompressed size of the chunk's records, in bytes.
    pub(super) size: u64,
    /// The checksum of the records; 0 if there is none.
    pub(super) checksum: u32,
    /// The compression name; empty if the records aren't compressed.
    pub(super) packing: Vec<u8>,
    /// The size of this header, in bytes.
    pub(super) length: usize,
    /// The size of the records in the file, in bytes.
    pub(super) packed: u64,
    /// The number of bytes after the records.
    pub(super) added: u64,
}

/// The maximum size of a chunk header, in bytes.
pub(super) const MAX_CHUNK_HEAD: usize = CHUNK_FIXED.0 + 4 + MAX_PACKING + CHUNK_FIXED.1;

impl ChunkHead {
    /// Parses the header of a chunk of `length` bytes. Returns `None` if its lengths contradict each other.
    pub(super) fn read(body: &[u8], length: u64) -> Option<Self> {
        let mut parts = Parts(body);
        parts.take(16)?;
        let size = parts.u64()?;
        let checksum = parts.u32()?;
        let packing = parts.u32().filter(|length| *length as usize <= MAX_PACKING)?;
        let packing = parts.take(packing as usize)?.to_vec();
        let packed = parts.u64()?;
        let head = body.len() - parts.0.len();
        let added = length.checked_sub(head as u64)?.checked_sub(packed)?;
        let is_whole = !packing.is_empty() || packed == size;
        (added <= MAX_ADDED && is_whole).then_some(Self {
            size,
            checksum,
            packing,
            length: head,
            packed,
            added,
        })
    }
}

/// The head of an attachment. Each of its texts includes its length prefix.
#[derive(Clone, Copy, Debug)]
pub struct AttachmentHead<'b> {
    /// The log time and the creation time.
    pub(crate) times: &'b [u8],
    /// The name.
    pub name: &'b [u8],
    /// The media type.
    pub media_type: &'b [u8],
    /// The length of the data, in bytes.
    pub(crate) size: u64,
    /// The length of the head, in bytes.
    length: usize,
}

impl<'b> AttachmentHead<'b> {
    /// Parses the start of an attachment. Returns `None` if it is too short.
    pub fn read(start: &'b [u8]) -> Option<Self> {
        let mut parts = Parts(start);
        let times = parts.take(16)?;
        let (name, media_type, size) = (parts.text()?, parts.text()?, parts.u64()?);
        Some(Self { times, name, media_type, size, length: start.len() - parts.0.len() })
    }

    /// True if the attachment has this name.
    pub fn is_named(&self, name: &str) -> bool {
        self.name.get(4..) == Some(name.as_bytes())
    }

    /// The data in the body of the attachment. `None` if the body is too short.
    pub fn data<'d>(&self, body: &'d [u8]) -> Option<&'d [u8]> {
        body.get(self.length..)?.get(..usize::try_from(self.size).ok()?)
    }
}

/// The position of an attachment's checksum in the record. `None` unless its header, data and checksum fit the record
/// length.
pub(super) fn attachment_checksum(start: &[u8], length: u64) -> Option<u64> {
    let head = AttachmentHead::read(start)?;
    let at = head.size.checked_add(head.length as u64)?;
    let added = length.checked_sub(at.checked_add(4)?)?;
    (added <= MAX_ADDED).then_some(at)
}

/// True if applications define the records with this opcode.
pub(super) fn is_private(opcode: u8) -> bool {
    opcode >= PRIVATE
}

/// True if the parts of a record match its length. Unless `is_exact` is true, the record may end with parts that later
/// versions of the format added.
pub(super) fn has_parts(opcode: u8, body: &[u8], is_exact: bool) -> bool {
    let mut parts = Parts(body);
    let parts_found = match opcode {
        op::HEADER => parts.text().and_then(|_| parts.text()).map(drop),
        op::SCHEMA => parts
            .take(2)
            .and_then(|_| parts.text())
            .and_then(|_| parts.text())
            .and_then(|_| parts.text())
            .map(drop),
        op::CHANNEL => {
            let names = parts.take(4).and_then(|_| parts.text()).and_then(|_| parts.text());
            names.and_then(|_| parts.texts())
        }
        op::MESSAGE_INDEX => parts.take(2).and_then(|_| parts.u32()).and_then(|length| {
            let entries = parts.take(length as usize)?;
            entries.len().is_multiple_of(16).then_some(())
        }),
        op::METADATA => parts.text().and_then(|_| parts.texts()),
        _ => return true,
    };
    parts_found.is_some() && (parts.0.is_empty() || !is_exact)
}

/// The message in a record.
pub(super) fn message(body: &[u8]) -> Option<Event<'_>> {
    let mut parts = Parts(body);
    let channel = parts.u16()?;
    let (sequence, time, publish_time) = (parts.u32()?, parts.u64()?, parts.u64()?);
    Some(Event::Message { channel, time, publish_time, sequence, payload: parts.0 })
}

/// The name and the values of a metadata record. `None` if the record contains invalid text or a duplicate key.
pub fn metadata(body: &[u8]) -> Option<(String, BTreeMap<String, String>)> {
    match mcap::parse_record(op::METADATA, body) {
        Ok(Record::Metadata(Metadata { name, metadata })) => Some((name, metadata)),
        _ => None,
    }
}

/// True if these bytes appear to be the start of a record. `is_declared` returns true for known channels.
///
/// Some kinds of records can't be recognised, so a search never stops at them.
pub(super) fn is_sound(ahead: &[u8], is_declared: impl Fn(u16) -> bool) -> bool {
    let Some((opcode, length)) = head(ahead) else { return false };
    let is_of_kind = matches!(
        opcode,
        op::FOOTER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::MESSAGE_INDEX | op::DATA_END
    );
    if !is_of_kind || !can_be(opcode, length) {
        return false;
    }
    let body = &ahead[HEAD..];
    if opcode == op::CHUNK {
        return ChunkHead::read(body, length).is_some_and(|head| head.added == 0);
    }
    let Some((body, rest)) = usize::try_from(length).ok().and_then(|length| body.split_at_checked(length))
    else {
        return false;
    };
    let channel = || body.first_chunk().map(|id| u16::from_le_bytes(*id));
    match opcode {
        op::FOOTER => length == FOOTER && rest.starts_with(&MAGIC),
        op::MESSAGE => channel().is_some_and(is_declared) && can_follow(rest),
        op::DATA_END => length == DATA_END && can_follow(rest),
        _ => has_parts(opcode, body, true),
    }
}

/// True if a record can start here. A record may extend beyond the known bytes.
pub(super) fn can_follow(ahead: &[u8]) -> bool {
    match head(ahead) {
        Some((opcode, length)) => {
            (opcode <= op::DATA_END || is_private(opcode)) && can_be(opcode, length) && length >> 40 == 0
        }
        None => ahead.is_empty(),
    }
}

/// Splits a record into its parts.
pub(super) struct Parts<'b>(pub(super) &'b [u8]);

impl<'b> Parts<'b> {
    pub(super) fn take(&mut self, length: usize) -> Option<&'b [u8]> {
        let (part, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(part)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(*self.take(2)?.first_chunk()?))
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(*self.take(8)?.first_chunk()?))
    }

    /// A length-prefixed string or map, including its length.
    pub(super) fn text(&mut self) -> Option<&'b [u8]> {
        let start = self.0;
        let length = self.u32()? as usize;
        self.take(length)?;
        start.get(..4 + length)
    }

    /// Skips a map of strings, which starts with the length of the whole map.
    fn texts(&mut self) -> Option<()> {
        let length = self.u32()?;
        let mut pairs = Parts(self.take(length as usize)?);
        while !pairs.0.is_empty() {
            pairs.text()?;
            pairs.text()?;
        }
        Some(())
    }
}
