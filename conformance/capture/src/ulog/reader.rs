//! Splits bytes into messages.

use std::collections::{BTreeSet, VecDeque};
use std::io::{self, Read};

use super::kind::{HEADER, Header};
use super::message::{Event, parse};
use super::problem::{Problem, Resync};
use super::resync::{Beginning, Ids, LOOKAHEAD, Look};
use crate::window::Window;

/// The size of the file header, in bytes.
const FILE_HEADER: usize = 16;

pub(super) const MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";

/// The newest supported version of the format.
const VERSION: u8 = 1;

/// The size of the known flag bits, in bytes.
const FLAG_BITS: usize = 40;

/// The only supported bit of `incompat_flags`: data was appended.
const KNOWN_INCOMPATIBLE: [u8; 8] = [1, 0, 0, 0, 0, 0, 0, 0];

/// A message or a problem, with its offset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item<'b> {
    /// The offset in the log. For a message, this is the offset of the header.
    pub offset: u64,
    /// The message or problem.
    pub event: Event<'b>,
    /// The bytes of the file header or of the message with its header; empty for most problems.
    pub bytes: &'b [u8],
}

/// Reads a log from any input, without seeking.
///
/// The input need not be buffered, since it is read in large pieces. Memory use doesn't depend on the size of the log.
#[derive(Debug)]
pub struct Reader<R> {
    window: Window<R>,
    state: State,
    /// The size of the message at the cursor, if it is clearly valid data. The check of the previous message includes this
    /// one, because a message is valid only if another one follows.
    certain: Option<u16>,
    sections: Sections,
    /// The problems to return before reading continues.
    queued: VecDeque<(u64, Problem)>,
    ids: Ids,
    /// The unknown kinds of messages so far.
    unknown: BTreeSet<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Start,
    /// Before the first message of a log with this version.
    First(u8),
    Messages,
    /// At the start of a run of messages found by a search. The first message isn't checked again.
    Found,
    /// After invalid bytes, which start at this offset.
    Lost(u64),
    Ended,
}

/// The next action. An action borrows nothing, so it can be chosen before an item borrows from the reader.
enum Step {
    Start { version: u8, timestamp: u64 },
    Message(Header),
    Problem(u64, Problem),
    End,
}

/// The sections of a log with appended data.
#[derive(Debug)]
struct Sections {
    /// The end of the current section.
    end: u64,
    /// The ends of the later sections.
    later: VecDeque<u64>,
}

impl<R: Read> Reader<R> {
    /// The buffer size in bytes, independent of the log size. It leaves most of the L2 cache to the caller. The buffer grows
    /// once the reader looks ahead.
    pub const CAPACITY: usize = 128 * 1024;

    /// The maximum number of bytes that the reader looks ahead after a suspicious message.
    pub const LOOKAHEAD: usize = LOOKAHEAD;

    /// Creates a reader without reading any input.
    pub fn new(input: R) -> Self {
        Self {
            window: Window::new(input, Self::CAPACITY),
            state: State::Start,
            certain: None,
            sections: Sections { end: u64::MAX, later: VecDeque::new() },
            queued: VecDeque::new(),
            ids: Ids::default(),
            unknown: BTreeSet::new(),
        }
    }

    /// The number of bytes that were read as messages or skipped.
    pub fn position(&self) -> u64 {
        self.window.offset()
    }

    /// The next message or problem; `None` at the end. Fails if the input can't be read. The caller may try again.
    // An iterator can't return items that borrow from it.
    #[allow(clippy::should_implement_trait)]
    #[inline]
    pub fn next(&mut self) -> io::Result<Option<Item<'_>>> {
        let Some(total) = self.data_ahead() else { return self.next_of_any_kind() };
        let offset = self.window.offset();
        self.window.advance(total);
        let bytes = self.window.behind(total);
        let event = match &bytes[HEADER..] {
            [low, high, payload @ ..] => Event::Data { id: u16::from_le_bytes([*low, *high]), payload },
            payload => Event::Unknown { kind: b'D', payload },
        };
        Ok(Some(Item { offset, event, bytes }))
    }

    /// The size of the next message with its header, if the message is clearly valid data and another such message
    /// follows in the buffer. Nearly all messages meet these conditions.
    #[inline]
    fn data_ahead(&mut self) -> Option<usize> {
        let size = match self.certain.take() {
            Some(size) => size,
            None if self.state == State::Messages && self.queued.is_empty() && self.ids.are_certain() => {
                self.data_at(0)?
            }
            None => return None,
        };
        let total = HEADER + usize::from(size);
        self.certain = self.data_at(total);
        self.certain.map(|_| total)
    }

    /// The size of the message this many bytes behind the cursor, if its header and id are in the buffer and it is clearly
    /// data.
    #[inline]
    fn data_at(&self, position: usize) -> Option<u16> {
        let [low, high, kind, id @ ..] =
            *self.window.ahead().get(position..)?.first_chunk::<{ Look::NEXT }>()?;
        let size = u16::from_le_bytes([low, high]);
        let end = self.window.offset() + (position + Look::NEXT) as u64;
        let is_data =
            kind == b'D' && self.ids.expect(size, u16::from_le_bytes(id)) && end <= self.sections.end;
        is_data.then_some(size)
    }

    fn next_of_any_kind(&mut self) -> io::Result<Option<Item<'_>>> {
        Ok(Some(match self.step()? {
            Step::Start { version, timestamp } => {
                let bytes = self.window.behind(FILE_HEADER);
                Item { offset: 0, event: Event::Start { version, timestamp }, bytes }
            }
            Step::Message(header) => self.lend(header),
            Step::Problem(offset, problem) => Item { offset, event: Event::Problem(problem), bytes: &[] },
            Step::End => return Ok(None),
        }))
    }

    fn step(&mut self) -> io::Result<Step> {
        loop {
            if let Some((offset, problem)) = self.queued.pop_front() {
                return Ok(Step::Problem(offset, problem));
            }
            match self.state {
                State::Start => return self.start(),
                State::First(version) => {
                    let beginning = self.classify()?;
                    self.state = State::Messages;
                    match beginning {
                        Beginning::Message(header) if header.kind == b'B' => {
                            self.state = State::First(version);
                            return Ok(Step::Message(header));
                        }
                        Beginning::End => {}
                        _ => return Ok(self.problem(Problem::NoFlagBits { version })),
                    }
                }
                State::Found => {
                    self.state = State::Messages;
                    if let Some(header) = Header::read(self.window.ahead()) {
                        return Ok(Step::Message(header));
                    }
                }
                State::Messages => {
                    let beginning = self.classify()?;
                    if let Some(step) = self.follow(beginning) {
                        return Ok(step);
                    }
                }
                State::Lost(from) => return self.search(from),
                State::Ended => return Ok(Step::End),
            }
        }
    }

    fn start(&mut self) -> io::Result<Step> {
        self.window.require(FILE_HEADER)?;
        let header = self.window.ahead();
        let found = header.len();
        let magic = header.first_chunk::<7>();
        if let Some(magic) = magic.filter(|magic| **magic != MAGIC) {
            self.state = State::Ended;
            return Ok(Step::Problem(0, Problem::ForeignMagic(*magic)));
        }
        let timestamp = header.get(MAGIC.len() + 1..).and_then(<[u8]>::first_chunk);
        let (Some(version), Some(timestamp)) = (header.get(MAGIC.len()), timestamp) else {
            self.state = State::Ended;
            return Ok(Step::Problem(0, Problem::ShortHeader { found }));
        };
        let (version, timestamp) = (*version, u64::from_le_bytes(*timestamp));
        self.window.advance(FILE_HEADER);
        self.state = State::First(version);
        if version > VERSION {
            self.queued.push_back((MAGIC.len() as u64, Problem::NewerVersion(version)));
        }
        Ok(Step::Start { version, timestamp })
    }

    /// Classifies the bytes at the cursor. Reads as few bytes as possible, so that messages from slow input aren't
    /// delayed.
    fn classify(&mut self) -> io::Result<Beginning> {
        self.window.require(HEADER)?;
        let wanted = Header::read(self.window.ahead()).map_or(0, |header| header.total() + Look::NEXT);
        self.window.require(wanted)?;
        if let Some(beginning) = self.look().classify() {
            return Ok(beginning);
        }
        self.window.require(LOOKAHEAD)?;
        Ok(self.look().classify_ahead())
    }

    fn follow(&mut self, beginning: Beginning) -> Option<Step> {
        match beginning {
            Beginning::Message(header) => Some(Step::Message(header)),
            Beginning::End => {
                self.end_section();
                None
            }
            Beginning::Truncated => Some(self.truncated_message()),
            Beginning::Skip(count, resync) => {
                let from = self.window.offset();
                self.window.advance(count);
                self.state = State::Found;
                let to = self.window.offset();
                Some(Step::Problem(from, Problem::Skipped { to, resync }))
            }
            Beginning::Lost(searched) => {
                self.state = State::Lost(self.window.offset());
                self.window.advance(searched);
                None
            }
        }
    }

    /// Searches for the next run of messages.
    fn search(&mut self, from: u64) -> io::Result<Step> {
        loop {
            self.window.require(LOOKAHEAD)?;
            let look = self.look();
            let (size, is_closed) = (look.bytes.len(), look.is_closed);
            // Later start positions are checked once all the bytes they may need have been read.
            let starts = if is_closed { size } else { size - LOOKAHEAD + 1 };
            let found = look.search(0..starts);
            self.window.advance(found.map_or(starts, |(at, _)| at));
            let end = if self.is_before_appended() { Resync::Appended } else { Resync::End };
            if let Some(resync) = found.map(|(_, resync)| resync).or(is_closed.then_some(end)) {
                self.state = if found.is_some() { State::Found } else { State::Messages };
                let to = self.window.offset();
                return Ok(Step::Problem(from, Problem::Skipped { to, resync }));
            }
        }
    }
}

impl<R> Reader<R> {
    /// The size of the buffer, in bytes.
    pub fn capacity(&self) -> usize {
        self.window.capacity()
    }

    /// Returns the message at the cursor.
    fn lend(&mut self, header: Header) -> Item<'_> {
        let offset = self.window.offset();
        self.window.advance(header.total());
        let Header { size, kind } = header;
        let bytes = self.window.behind(header.total());
        let payload = &bytes[HEADER..];
        let event = match parse(kind, payload) {
            Ok((event, defect)) => {
                self.queued.extend(
                    defect.map(|malformation| (offset, Problem::InvalidContent { kind, malformation })),
                );
                event
            }
            Err(malformation) => Event::Problem(Problem::Malformed { kind, size: size.into(), malformation }),
        };
        match event {
            Event::Subscription { id, .. } => self.ids.subscribe(id),
            Event::Data { id, .. } => self.ids.see(id, size),
            Event::Unknown { kind, .. } if self.unknown.insert(kind) => {
                self.queued.push_back((offset, Problem::UnknownKind(kind)));
            }
            Event::FlagBits { .. } if self.state == State::Messages => {
                self.queued.push_back((offset, Problem::FlagBitsNotFirst));
            }
            Event::FlagBits { incompatible, appended, .. } => {
                if payload.len() > FLAG_BITS {
                    self.queued.push_back((offset, Problem::FlagBitsLonger { size: payload.len() }));
                }
                let refused: [u8; 8] = std::array::from_fn(|at| incompatible[at] & !KNOWN_INCOMPATIBLE[at]);
                if refused == [0; 8] {
                    let is_flagged = incompatible[0] & 1 != 0;
                    let refused = self.sections.append(self.window.offset(), appended, is_flagged);
                    self.queued.extend(refused.map(|at| (offset, Problem::AppendedOffset(at))));
                } else {
                    self.queued.push_back((offset, Problem::UnknownIncompatible(refused)));
                    self.state = State::Ended;
                }
            }
            _ => {}
        }
        if matches!(self.state, State::First(_)) {
            self.state = State::Messages;
        }
        Item { offset, event, bytes }
    }

    /// Skips a message that extends beyond the end of its section.
    fn truncated_message(&mut self) -> Step {
        let offset = self.window.offset();
        let bytes = self.look().bytes;
        let found = bytes.len();
        let header = Header::read(bytes);
        self.window.advance(found);
        let problem = if self.is_before_appended() {
            Problem::Straddles { appended: self.sections.end }
        } else if let Some(Header { size, kind }) = header {
            Problem::EndsInPayload { kind, size: size.into(), found: found - HEADER }
        } else {
            Problem::EndsInHeader { found }
        };
        Step::Problem(offset, problem)
    }

    /// Continues with the data that was appended at the cursor, unless the log has ended.
    fn end_section(&mut self) {
        if self.is_before_appended() {
            self.sections.end = self.sections.later.pop_front().unwrap_or(u64::MAX);
            return;
        }
        self.state = State::Ended;
        let offset = self.window.offset();
        let left = [self.sections.end].into_iter().chain(self.sections.later.drain(..));
        let left = left.filter(|at| *at != u64::MAX);
        self.queued.extend(left.map(|at| (offset, Problem::AppendedBeyondEnd(at))));
    }

    /// True if appended data starts at the cursor.
    fn is_before_appended(&self) -> bool {
        self.window.offset() == self.sections.end
    }

    fn problem(&self, problem: Problem) -> Step {
        Step::Problem(self.window.offset(), problem)
    }

    /// The bytes after the cursor that belong to the current section and are in the buffer.
    fn look(&self) -> Look<'_> {
        let ahead = self.window.ahead();
        let left = self.sections.end - self.window.offset();
        let within = usize::try_from(left).ok().and_then(|left| ahead.get(..left));
        Look {
            bytes: within.unwrap_or(ahead),
            is_closed: within.is_some() || self.window.is_at_end(),
            is_first: matches!(self.state, State::First(_)),
            ids: &self.ids,
        }
    }
}

impl Sections {
    /// Stores the offsets of appended data, which must increase from `at`. Returns the invalid offsets.
    fn append(&mut self, at: u64, offsets: [u64; 3], is_flagged: bool) -> impl Iterator<Item = u64> {
        let mut last = at.saturating_sub(1);
        let mut refused = Vec::new();
        for offset in offsets.into_iter().filter(|offset| *offset != 0) {
            if is_flagged && offset > last && offset != u64::MAX {
                self.later.push_back(offset);
                last = offset;
            } else {
                refused.push(offset);
            }
        }
        self.end = self.later.pop_front().unwrap_or(u64::MAX);
        refused.into_iter()
    }
}
