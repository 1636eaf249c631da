//! Reads a file record by record.

use std::collections::VecDeque;
use std::io::{self, Read};
use std::mem;

use mcap::records::{Record, op};

use super::census::Census;
use super::chunk::{Chunk, Next, Records, next_record};
use super::problem::Malformed;
use super::sound::{
    self, ChunkHead, HEAD, MAX_CHUNK_HEAD, Parts, attachment_checksum, can_be, can_follow, has_parts,
    is_private, is_sound, message,
};
use super::unpack::{Packing, Unpacker};
use super::window::Window;
use super::{Event, Item, MAGIC, Problem};
use crate::limits::MAX_PACKED;

/// The size in bytes of the window that is searched for the next valid record. The search doesn't find messages that
/// are longer than this window.
const LOOKAHEAD: usize = 64 * 1024;

/// Reads a file from start to end.
pub struct Reader<R> {
    file: Window<R>,
    stage: Stage,
    /// The chunk that contains the cursor.
    chunk: Option<Chunk>,
    /// The attachment that contains the cursor.
    attachment: Option<Attachment>,
    /// The problems to return before the next record.
    problems: VecDeque<(u64, Problem)>,
    census: Census,
    /// The offset of the current file. Another file may follow its end.
    start: u64,
    /// True if the header of the current file was read.
    has_header: bool,
    /// The offset of the summary in the current file, once it has been reached.
    summary: Option<u64>,
    /// True if the current file has had no problems so far.
    is_sound: bool,
}

/// An attachment that is being read.
#[derive(Clone, Copy, Debug)]
struct Attachment {
    offset: u64,
    length: u64,
    /// The position of the cursor in the body.
    at: u64,
    /// The position of the checksum in the body.
    checksum_at: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Start,
    Header,
    Records,
    End,
}

/// A record that ends at the cursor.
#[derive(Clone, Copy, Debug)]
struct Found {
    offset: u64,
    opcode: u8,
    length: usize,
    is_packed: bool,
}

impl<R: Read> Reader<R> {
    /// Creates a reader at the first byte of `input`.
    pub fn new(input: R) -> Self {
        Self {
            file: Window::new(input),
            stage: Stage::Start,
            chunk: None,
            attachment: None,
            problems: VecDeque::new(),
            census: Census::default(),
            start: 0,
            has_header: false,
            summary: None,
            is_sound: true,
        }
    }

    /// The number of bytes read.
    pub fn bytes(&self) -> u64 {
        self.file.offset()
    }

    /// The next problem or relevant record. All records are relevant except structural ones, such as indexes. Another
    /// header belongs to a file that follows the end of the previous file. `None` at the end.
    ///
    /// Fails if the input can't be read. The caller may try again.
    #[allow(clippy::should_implement_trait)] // an iterator's items can't borrow from it
    pub fn next(&mut self) -> io::Result<Option<Item<'_>>> {
        loop {
            if let Some((offset, problem)) = self.problems.pop_front() {
                return Ok(Some(Item { offset, packing: None, event: Event::Problem(problem) }));
            }
            if let Some(attachment) = self.attachment {
                if let Some(length) = self.attachment_part(attachment)? {
                    let Attachment { offset, length: whole, at, .. } = attachment;
                    let event = Event::Attachment { length: whole, at, bytes: self.file.behind(length) };
                    return Ok(Some(Item { offset, packing: None, event }));
                }
                continue;
            }
            let found = match (&self.chunk, self.stage) {
                (Some(_), _) => self.in_chunk()?,
                (None, Stage::End) => return Ok(None),
                (None, Stage::Start) => self.start()?,
                (None, Stage::Header | Stage::Records) => self.in_file()?,
            };
            if let Some(found) = found {
                return Ok(Some(self.lend(found)));
            }
        }
    }

    fn lend(&mut self, found: Found) -> Item<'_> {
        let Found { offset, opcode, length, is_packed } = found;
        let body = match &self.chunk {
            Some(Chunk { records: Records::Packed(window, _), .. }) if is_packed => window.behind(length),
            _ => self.file.behind(length),
        };
        let is_in_chunk = self.chunk.is_some();
        let packing = self.chunk.as_ref().and_then(|chunk| chunk.packing);
        let is_in_summary = self.summary.is_some();
        if opcode == op::MESSAGE
            && let Some(event) = message(body)
        {
            if let Event::Message { channel, time, .. } = event {
                self.census.message(channel, time, is_in_chunk);
            }
            return Item { offset, packing, event };
        }
        if opcode == op::METADATA {
            return Item { offset, packing, event: Event::Metadata { body } };
        }
        if is_private(opcode) {
            return Item { offset, packing, event: Event::Private { opcode, body, is_in_chunk } };
        }
        let event = match mcap::parse_record(opcode, body) {
            Ok(Record::Header(header)) => Event::Header { profile: header.profile, library: header.library },
            // The text of a schema is borrowed from the record.
            Ok(Record::Schema { header, data: std::borrow::Cow::Borrowed(text) }) => {
                self.census.schemas.add(header.id, is_in_summary);
                Event::Schema { id: header.id, name: header.name, encoding: header.encoding, text }
            }
            Ok(Record::Channel(channel)) => {
                self.census.channels.add(channel.id, is_in_summary);
                Event::Channel {
                    id: channel.id,
                    schema: channel.schema_id,
                    topic: channel.topic,
                    encoding: channel.message_encoding,
                    metadata: channel.metadata,
                }
            }
            _ => Event::Problem(Problem::Unreadable { opcode }),
        };
        Item { offset, packing, event }
    }

    /// Reads a part of an attachment. Returns its length; `None` at the end.
    fn attachment_part(&mut self, attachment: Attachment) -> io::Result<Option<usize>> {
        let Attachment { offset, length, at, checksum_at } = attachment;
        if at == length {
            self.attachment = None;
            return Ok(None);
        }
        if at == checksum_at {
            self.check_attachment(offset)?;
        }
        self.file.require(1)?;
        let left = length - at;
        let until = if at < checksum_at { checksum_at - at } else { left };
        let here = usize::try_from(until).unwrap_or(usize::MAX).min(self.file.ahead().len());
        if here == 0 {
            self.attachment = None;
            self.report(offset, Problem::Truncated { missing: left });
            self.stage = Stage::End;
            return Ok(None);
        }
        self.file.advance(here);
        self.attachment = Some(Attachment { at: at + here as u64, ..attachment });
        Ok(Some(here))
    }

    /// Verifies the checksum of an attachment at the cursor. A stored value of 0 means that there is no checksum.
    fn check_attachment(&mut self, offset: u64) -> io::Result<()> {
        let found = self.file.part_checksum();
        self.file.require(4)?;
        let stated = self.file.ahead().first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        self.check_sum(offset, "attachment", stated, found);
        Ok(())
    }

    /// Compares a checksum with the stated one. A stated value of 0 means that there is no checksum.
    fn check_sum(&mut self, offset: u64, part: &'static str, stated: u32, found: u32) {
        if stated != 0 && stated != found {
            self.report(offset, Problem::Checksum { part, stated, found });
        }
    }

    fn report(&mut self, offset: u64, problem: Problem) {
        self.is_sound = false;
        self.problems.push_back((offset, problem));
    }

    fn start(&mut self) -> io::Result<Option<Found>> {
        self.stage = Stage::Header;
        self.file.require(MAGIC.len())?;
        if self.file.ahead().starts_with(&MAGIC) {
            self.file.advance(MAGIC.len());
        } else {
            self.report(0, Problem::NoMagic);
        }
        Ok(None)
    }

    /// Reads the next record outside of chunks.
    fn in_file(&mut self) -> io::Result<Option<Found>> {
        self.file.require(HEAD)?;
        let offset = self.file.offset();
        let Some((opcode, length)) = sound::head(self.file.ahead()) else {
            self.ends_early(offset)?;
            return Ok(None);
        };
        if mem::replace(&mut self.stage, Stage::Records) == Stage::Header && opcode != op::HEADER {
            self.report(offset, Problem::NoHeader);
        }
        if !can_be(opcode, length) {
            self.search(offset, Malformed::Length { opcode, length })?;
            return Ok(None);
        }
        match opcode {
            op::CHUNK => self.open(offset, length)?,
            op::ATTACHMENT => {
                self.file.require(LOOKAHEAD)?;
                let Some(checksum_at) = attachment_checksum(&self.file.ahead()[HEAD..], length) else {
                    self.search(offset, Malformed::Parts { opcode })?;
                    return Ok(None);
                };
                self.expect(offset, opcode);
                self.census.attachment(offset - self.start, HEAD as u64 + length);
                self.file.advance(HEAD);
                self.file.start_part();
                self.attachment = Some(Attachment { offset, length, at: 0, checksum_at });
            }
            // The length was checked, so this doesn't overflow.
            _ => {
                return self.buffered_record(
                    offset,
                    opcode,
                    usize::try_from(length).unwrap_or(usize::MAX - HEAD),
                );
            }
        }
        Ok(None)
    }

    /// Reads a complete record into the buffer, so that the bytes after it can be checked.
    fn buffered_record(&mut self, offset: u64, opcode: u8, length: usize) -> io::Result<Option<Found>> {
        let end = HEAD + length;
        self.file.require(end + HEAD)?;
        let ahead = self.file.ahead();
        let problem = match (ahead.get(HEAD..end), ahead.get(end..)) {
            (Some(body), Some(rest)) => {
                let lacks_end_magic =
                    opcode == op::FOOTER && rest.len() >= MAGIC.len() && !rest.starts_with(&MAGIC);
                if lacks_end_magic || !has_parts(opcode, body, false) {
                    Some(Malformed::Parts { opcode })
                } else if opcode != op::FOOTER && !can_follow(rest) {
                    Some(Malformed::Follower { opcode })
                } else {
                    None
                }
            }
            _ => Some(Malformed::Beyond { opcode, length: length as u64 }),
        };
        if let Some(problem) = problem {
            let is_whole = ahead.len() >= end;
            // A record that starts within the current record may extend beyond it.
            self.file.require(end.saturating_add(LOOKAHEAD))?;
            let next = self.sound_record(1, end);
            match (next, problem) {
                (Some(next), _) => {
                    self.file.advance(next);
                    self.report(offset, Problem::Skipped { found: problem, length: next as u64 });
                    return Ok(None);
                }
                // The record itself is plausible; the bytes after it are checked next.
                (None, Malformed::Follower { .. }) => {}
                (None, _) if is_whole => {
                    self.search(offset, problem)?;
                    return Ok(None);
                }
                (None, _) => {
                    self.skip(offset, end as u64)?;
                    return Ok(None);
                }
            }
        }
        self.expect(offset, opcode);
        if opcode == op::FOOTER {
            self.footer(offset, end);
            self.end()?;
            return Ok(None);
        }
        self.count(offset, opcode, end);
        self.file.advance(end);
        if opcode == op::DATA_END {
            self.file.start_part();
        }
        let is_wanted = match opcode {
            op::HEADER => !mem::replace(&mut self.has_header, true),
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA => true,
            opcode => is_private(opcode),
        };
        Ok(is_wanted.then_some(Found { offset, opcode, length, is_packed: false }))
    }

    /// Reports a record of an unknown kind, or in a part of the file where its kind isn't allowed.
    fn expect(&mut self, offset: u64, opcode: u8) {
        let is_in_summary = self.summary.is_some();
        let is_expected = match opcode {
            op::HEADER => !self.has_header,
            op::SCHEMA | op::CHANNEL => true,
            op::MESSAGE | op::CHUNK | op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA | op::DATA_END => {
                !is_in_summary
            }
            op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::METADATA_INDEX
            | op::STATISTICS
            | op::SUMMARY_OFFSET
            | op::FOOTER => is_in_summary,
            opcode => is_private(opcode),
        };
        if !is_expected {
            self.report(offset, Problem::Misplaced { opcode });
        }
    }

    /// Counts the record at the cursor, which is `end` bytes long. If it is an end-of-data record, also verifies its
    /// checksum and the indexes of the latest chunk.
    fn count(&mut self, offset: u64, opcode: u8, end: usize) {
        if opcode == op::DATA_END {
            self.close_chunk();
            let stated =
                self.file.ahead()[HEAD..].first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            let found = self.file.checksum();
            self.check_sum(offset, "data", stated, found);
            self.summary = Some(offset + end as u64);
        }
        let body = &self.file.ahead()[HEAD..end];
        if let Some(problem) = self.census.record(opcode, offset - self.start, end as u64, body) {
            self.report(offset, problem);
        }
    }

    /// Compares the latest chunk with its indexes.
    fn close_chunk(&mut self) {
        if let Some((chunk, problem)) = self.census.close_chunk().filter(|_| self.is_sound) {
            self.report(self.start + chunk, problem);
        }
    }

    /// Reads the footer at the cursor, which ends after `end` bytes. Compares it, the statistics and the indexes with the
    /// file.
    fn footer(&mut self, offset: u64, end: usize) {
        let mut parts = Parts(&self.file.ahead()[HEAD..end]);
        let (stated, _, checksum) = (parts.u64(), parts.u64(), parts.u32());
        // The checksum covers the fields before it.
        let left = parts.0.len() + size_of::<u32>();
        self.file.advance(end - left);
        let found = self.file.part_checksum();
        self.file.advance(left);
        if !self.is_sound {
            return;
        }
        self.check_sum(offset, "summary", checksum.unwrap_or_default(), found);
        let summary = self.summary.unwrap_or(offset) - self.start;
        if let Some(stated) = stated.filter(|stated| *stated != 0 && *stated != summary) {
            self.report(offset, Problem::SummaryStart { stated, found: summary });
        }
        for problem in self.census.differences() {
            self.report(offset, problem);
        }
    }

    /// Reports that the file ends without a footer.
    fn ends_early(&mut self, offset: u64) -> io::Result<()> {
        let left = self.file.skip(u64::MAX)?;
        if left > 0 {
            self.report(offset, Problem::Truncated { missing: HEAD as u64 - left });
        } else {
            self.report(offset, Problem::NoEnd);
        }
        self.stage = Stage::End;
        Ok(())
    }

    /// Reads the bytes after the footer.
    fn end(&mut self) -> io::Result<()> {
        self.file.require(MAGIC.len())?;
        let offset = self.file.offset();
        if self.file.ahead().starts_with(&MAGIC) {
            self.file.advance(MAGIC.len());
        } else {
            self.report(offset, Problem::NoEnd);
        }
        self.file.require(MAGIC.len())?;
        if self.file.ahead().starts_with(&MAGIC) {
            self.restart();
            return Ok(());
        }
        let (offset, mut is_empty) = (self.file.offset(), true);
        self.stage = Stage::End;
        loop {
            let length = self.file.ahead().len();
            is_empty &= self.file.ahead().iter().all(|byte| *byte == 0);
            self.file.advance(length);
            self.file.require(1)?;
            if self.file.ahead().is_empty() {
                break;
            }
        }
        // Some storage adds zeros.
        if !is_empty {
            self.report(offset, Problem::AfterEnd { length: self.file.offset() - offset });
        }
        Ok(())
    }

    /// Continues with the file that starts at the cursor.
    fn restart(&mut self) {
        self.stage = Stage::Start;
        self.start = self.file.offset();
        self.file.restart();
        self.census = Census::default();
        (self.has_header, self.summary, self.is_sound) = (false, None, true);
    }

    /// Skips bytes of the record at `offset`.
    fn skip(&mut self, offset: u64, length: u64) -> io::Result<()> {
        let passed = self.file.skip(length)?;
        if passed < length {
            self.report(offset, Problem::Truncated { missing: length - passed });
            self.stage = Stage::End;
        }
        Ok(())
    }

    /// Skips to the next valid record, or to the end.
    fn search(&mut self, offset: u64, found: Malformed) -> io::Result<()> {
        let start = self.file.offset();
        self.file.require(1)?;
        // The bytes at the cursor aren't a valid record.
        let mut from = self.file.ahead().len().min(1);
        loop {
            self.file.require(2 * LOOKAHEAD)?;
            let length = self.file.ahead().len();
            // Unless the file ends, each possible start must be followed by enough bytes to check a record.
            let until = if self.file.is_at_end() { length } else { length - LOOKAHEAD };
            let next = self.sound_record(from, until);
            let (is_over, passed) = (self.file.is_at_end(), next.unwrap_or(until));
            self.file.advance(passed);
            from = 0;
            if next.is_some() || is_over {
                break;
            }
        }
        let length = self.file.offset() - start;
        self.report(offset, Problem::Skipped { found, length });
        Ok(())
    }

    /// The first position in a range of the buffered bytes at which a valid record starts. A record is checked up to a
    /// fixed length, because the result must not depend on the number of bytes that a read returned.
    fn sound_record(&self, from: usize, until: usize) -> Option<usize> {
        let ahead = self.file.ahead();
        let is_sound_at = |at: &usize| {
            let end = ahead.len().min(at.saturating_add(LOOKAHEAD));
            is_sound(&ahead[*at..end], |id| self.census.has_channel(id))
        };
        (from..until.min(ahead.len())).find(is_sound_at)
    }

    /// Opens a chunk of `length` bytes.
    fn open(&mut self, offset: u64, length: u64) -> io::Result<()> {
        self.file.require(HEAD + MAX_CHUNK_HEAD)?;
        let body = &self.file.ahead()[HEAD..];
        let Some(head) = ChunkHead::read(body, length) else {
            // The file ends within the header of the chunk.
            let left = self.file.ahead().len();
            if left < HEAD + MAX_CHUNK_HEAD && (left as u64) < HEAD as u64 + length {
                return self.skip(offset, HEAD as u64 + length);
            }
            return self.search(offset, Malformed::Parts { opcode: op::CHUNK });
        };
        let packing = Packing::from_name(&head.packing);
        if packing.is_some() && head.packed > MAX_PACKED {
            return self.search(offset, Malformed::Length { opcode: op::CHUNK, length });
        }
        if packing.is_none() && !head.packing.is_empty() {
            let name = String::from_utf8_lossy(&head.packing).into_owned();
            self.report(offset, Problem::Packing { name });
            return self.skip(offset, HEAD as u64 + length);
        }
        self.expect(offset, op::CHUNK);
        let facts = [offset - self.start, HEAD as u64 + length, head.size, head.packed];
        if let Some((chunk, problem)) = self.census.chunk(facts).filter(|_| self.is_sound) {
            self.report(self.start + chunk, problem);
        }
        self.file.advance(HEAD + head.length);
        self.file.start_part();
        let ChunkHead { size, checksum, added, packed, .. } = head;
        let records = match packing {
            None => Records::Plain(self.file.offset()),
            Some(packing) => {
                // The size is within the limit, so it fits into a `usize`.
                let packed = usize::try_from(packed).unwrap_or(usize::MAX);
                let taken = self.file.take(packed)?;
                let missing = packed - taken.len();
                if missing > 0 {
                    self.report(offset, Problem::Truncated { missing: missing as u64 + added });
                    self.stage = Stage::End;
                }
                Records::Packed(Box::new(Window::new(Unpacker::new(packing, taken)?)), missing > 0)
            }
        };
        self.chunk = Some(Chunk { offset, size, checksum, packing, added, records });
        Ok(())
    }

    /// Reads the next record of the current chunk.
    fn in_chunk(&mut self) -> io::Result<Option<Found>> {
        let Some(chunk) = &mut self.chunk else { return Ok(None) };
        let (chunk_offset, size, is_packed) = (chunk.offset, chunk.size, chunk.packing.is_some());
        let (next, record_offset) = match &mut chunk.records {
            Records::Plain(start) => {
                let offset = self.file.offset();
                (next_record(&mut self.file, size - (offset - *start))?, offset)
            }
            Records::Packed(window, is_truncated) => {
                let left = size - window.offset();
                match next_record(window, left) {
                    Ok(next) => (next, chunk_offset),
                    Err(error) => {
                        let unpacked = window.offset() + window.ahead().len() as u64;
                        // The missing bytes have been reported already.
                        if !*is_truncated {
                            let error = error.to_string();
                            self.is_sound = false;
                            self.problems.push_back((chunk_offset, Problem::Unpack { unpacked, error }));
                        }
                        self.leave()?;
                        return Ok(None);
                    }
                }
            }
        };
        match next {
            Next::Record { opcode, length } => {
                return Ok(Some(Found { offset: record_offset, opcode, length, is_packed }));
            }
            Next::Passed { opcode } => self.report(record_offset, Problem::Misplaced { opcode }),
            Next::TooLong { opcode, length } => {
                self.report(record_offset, Problem::TooLong { opcode, length });
            }
            Next::Corrupt => self.corrupt_chunk()?,
            Next::End => self.close()?,
        }
        Ok(None)
    }

    /// Handles a chunk without a valid record at the cursor.
    fn corrupt_chunk(&mut self) -> io::Result<()> {
        let Some(chunk) = &mut self.chunk else { return Ok(()) };
        let (offset, size) = (chunk.offset, chunk.size);
        match &mut chunk.records {
            Records::Packed(window, is_truncated) => {
                let at = window.offset();
                let problem = if window.is_at_end() && window.ahead().is_empty() {
                    Problem::ChunkSize { stated: size, found: at, is_more: false }
                } else {
                    Problem::InChunk { at }
                };
                if !*is_truncated {
                    self.report(offset, problem);
                }
                self.leave()
            }
            Records::Plain(start) => {
                let left = size - (self.file.offset() - *start);
                self.chunk = None;
                let ahead = self.file.ahead();
                let is_truncated = self.file.is_at_end() && (ahead.len() as u64) < left;
                let is_next = |at: &usize| is_sound(&ahead[*at..], |id| self.census.has_channel(id));
                if is_truncated && !(1..ahead.len()).any(|at| is_next(&at)) {
                    return self.skip(offset, left);
                }
                let (opcode, length) = sound::head(ahead).unwrap_or_default();
                self.search(self.file.offset(), Malformed::Beyond { opcode, length })
            }
        }
    }

    /// Leaves a chunk after its last record, and verifies the chunk's checksum.
    fn close(&mut self) -> io::Result<()> {
        let Some(chunk) = &mut self.chunk else { return Ok(()) };
        let (offset, stated) = (chunk.offset, chunk.checksum);
        let found = match &mut chunk.records {
            Records::Plain(_) => self.file.part_checksum(),
            Records::Packed(window, _) => {
                let found = window.part_checksum();
                // If the data after the last record can't be decompressed, no records are lost.
                if window.require(1).is_ok() && !window.ahead().is_empty() {
                    let size = chunk.size;
                    let problem = Problem::ChunkSize { stated: size, found: size, is_more: true };
                    self.is_sound = false;
                    self.problems.push_back((offset, problem));
                }
                found
            }
        };
        if stated != 0 && stated != found {
            self.report(offset, Problem::ChunkChecksum { stated, found });
        }
        self.leave()
    }

    /// Moves past the current chunk.
    fn leave(&mut self) -> io::Result<()> {
        let Some(chunk) = self.chunk.take() else { return Ok(()) };
        if self.stage == Stage::End { Ok(()) } else { self.skip(chunk.offset, chunk.added) }
    }
}
