//! Reads JSON Lines, and files that are one JSON value, several, or an array of them: cuts them into the texts of
//! single values, which it lends from its buffer without looking into them.
//!
//! What a file is, is seen by its content. One that begins with `[` is an array, and its elements are the values.
//! One whose first line ends within a value, and whose second doesn't begin another, is written over several
//! lines. All others are JSON Lines: there a broken line spoils nothing but itself.

use std::fmt;
use std::io::{self, ErrorKind, Read};

use crate::json::Frame;
use crate::model::Extent;

/// The longest value that is read: nothing that is sent as a message comes near it.
pub(crate) const MAX_LENGTH: usize = 16 << 20;

/// How much is read at a time.
const CHUNK: usize = 1 << 16;

/// The byte order mark in UTF-8.
const BOM: &[u8] = b"\xef\xbb\xbf";

/// The text of a value, or something that is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Item<'r> {
    /// The line in which it begins, from 1.
    pub line: u64,
    /// What is there.
    pub event: Event<'r>,
}

/// What comes from a source of JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event<'r> {
    /// What should be the text of a value.
    Value {
        /// Its bytes.
        bytes: &'r [u8],
        /// Whether the source ends behind it, without a line end or what else should follow.
        is_last: bool,
    },
    /// Something that can't be read.
    Problem(Problem),
}

/// What can't be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Problem {
    /// The source begins with a byte order mark.
    ByteOrderMark,
    /// A value is longer than [`MAX_LENGTH`]; it was skipped.
    TooLong {
        /// Its length, in bytes.
        length: u64,
    },
    /// A bracket that closes nothing, or a comma, stands where a value should.
    Stray(u8),
    /// No comma stands between two elements of an array; this is what follows.
    NoComma(u8),
    /// The array isn't closed.
    Unclosed,
}

impl Problem {
    /// How much of the source can be read that has it.
    pub(crate) fn extent(&self) -> Extent {
        match self {
            Self::ByteOrderMark => Extent::Whole,
            Self::Unclosed => Extent::EndsEarly,
            Self::TooLong { .. } | Self::Stray(_) | Self::NoComma(_) => Extent::WithGaps,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ByteOrderMark => formatter
                .write_str("a byte order mark, which JSON must not begin with (RFC 8259, section 8.1)"),
            Self::TooLong { length } => {
                write!(formatter, "{length} bytes, where at most {MAX_LENGTH} are read; skipped")
            }
            Self::Stray(byte) => write!(formatter, "`{}` where a value should be", byte.escape_ascii()),
            Self::NoComma(byte) => write!(formatter, "`{}` where a comma should be", byte.escape_ascii()),
            Self::Unclosed => formatter.write_str("the array is not closed"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// A value a line.
    Lines,
    /// Values of any number of lines.
    Values,
    /// The elements of an array.
    Array,
}

/// Cuts a source into values.
#[derive(Debug)]
pub(crate) struct Reader<R> {
    input: R,
    buffer: Vec<u8>,
    /// What of the buffer has been lent.
    start: usize,
    /// What of it has been read.
    end: usize,
    mode: Option<Mode>,
    /// The line at `start`.
    line: u64,
    /// How many bytes were read.
    read: u64,
    /// The last byte that was read.
    last: Option<u8>,
    /// What comes next in an array.
    next: Next,
}

/// What comes next in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// The first value, or the end.
    First,
    Value,
    /// A comma, or the end.
    Comma,
    /// Nothing: the array is closed.
    Nothing,
}

impl<R: Read> Reader<R> {
    /// Reads from the start.
    pub(crate) fn new(input: R) -> Self {
        Self {
            input,
            buffer: Vec::new(),
            start: 0,
            end: 0,
            mode: None,
            line: 1,
            read: 0,
            last: None,
            next: Next::First,
        }
    }

    /// How many bytes were read.
    pub(crate) fn bytes(&self) -> u64 {
        self.read
    }

    /// How many lines there were so far.
    pub(crate) fn lines(&self) -> u64 {
        // A line that isn't ended is one too.
        self.line - 1 + u64::from(self.last.is_some_and(|byte| byte != b'\n'))
    }

    /// The next value or problem; none at the end.
    #[allow(clippy::should_implement_trait)] // an iterator can't lend
    pub(crate) fn next(&mut self) -> io::Result<Option<Item<'_>>> {
        let mode = if let Some(mode) = self.mode {
            mode
        } else {
            if self.begins_with_mark()? {
                return Ok(Some(problem(self.line, Problem::ByteOrderMark)));
            }
            self.look()?
        };
        self.mode = Some(mode);
        match mode {
            Mode::Lines => self.next_line(),
            Mode::Values | Mode::Array => self.next_value(mode == Mode::Array),
        }
    }

    fn rest(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Reads more; what was lent goes. False at the end.
    fn fill(&mut self) -> io::Result<bool> {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        // Large values are read in large pieces, so that moving them stays cheap.
        let room = self.end + CHUNK.max(self.end.min(MAX_LENGTH));
        if self.buffer.len() < room {
            self.buffer.resize(room, 0);
        }
        let read = loop {
            match self.input.read(&mut self.buffer[self.end..room]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        self.end += read;
        self.read += read as u64;
        self.last = self.rest().last().copied().or(self.last);
        Ok(read > 0)
    }

    /// Takes bytes that are done with.
    fn take(&mut self, count: usize) {
        self.take_lines(count, memchr::memchr_iter(b'\n', &self.rest()[..count]).count() as u64);
    }

    /// Takes bytes in which so many lines end.
    fn take_lines(&mut self, count: usize, lines: u64) {
        self.line += lines;
        self.start += count;
    }

    fn begins_with_mark(&mut self) -> io::Result<bool> {
        while self.rest().len() < BOM.len() && self.fill()? {}
        let is_marked = self.rest().starts_with(BOM);
        if is_marked {
            self.take(BOM.len());
        }
        Ok(is_marked)
    }

    /// What kind of source it is, by its first line and how the next one begins.
    fn look(&mut self) -> io::Result<Mode> {
        let mut frame = Frame::default();
        let mut is_second = false;
        let mut at = 0;
        loop {
            while let Some(byte) = self.rest().get(at).copied() {
                match (is_second, byte) {
                    (false, b'[') if frame.is_fresh() => {
                        self.take(at + 1);
                        return Ok(Mode::Array);
                    }
                    (false, b'\n') if !frame.is_fresh() => {
                        if !frame.is_within() {
                            return Ok(Mode::Lines);
                        }
                        is_second = true;
                    }
                    (_, b' ' | b'\t' | b'\r' | b'\n') => {}
                    (false, byte) => _ = frame.step(byte),
                    (true, b'{') => return Ok(Mode::Lines),
                    (true, _) => return Ok(Mode::Values),
                }
                at += 1;
            }
            if at > MAX_LENGTH || !self.fill()? {
                return Ok(Mode::Lines);
            }
        }
    }

    /// JSON Lines.
    fn next_line(&mut self) -> io::Result<Option<Item<'_>>> {
        let (mut seen, mut skipped) = (0, 0);
        let (end, is_last) = loop {
            if let Some(found) = memchr::memchr(b'\n', &self.rest()[seen..]) {
                let end = seen + found;
                let is_blank = skipped == 0 && self.rest()[..end].trim_ascii().is_empty();
                if !is_blank {
                    break (end + 1, false);
                }
                self.take_lines(end + 1, 1);
                seen = 0;
                continue;
            }
            seen = self.rest().len();
            if seen > MAX_LENGTH {
                skipped += seen as u64;
                self.start += seen;
                seen = 0;
            }
            if !self.fill()? {
                if skipped == 0 && self.rest().trim_ascii().is_empty() {
                    self.start = self.end;
                    return Ok(None);
                }
                break (self.rest().len(), true);
            }
        };
        let line = self.line;
        self.take_lines(end, u64::from(!is_last));
        Ok(Some(self.lend(line, end, skipped, is_last)))
    }

    /// Lends the bytes that were just taken, of which some were skipped if there were too many.
    fn lend(&self, line: u64, count: usize, skipped: u64, is_last: bool) -> Item<'_> {
        let start = self.start - count;
        let bytes = self.buffer[start..self.start].trim_ascii();
        if skipped > 0 || bytes.len() > MAX_LENGTH {
            let length = skipped + bytes.len() as u64;
            return problem(line, Problem::TooLong { length });
        }
        Item { line, event: Event::Value { bytes, is_last } }
    }

    /// Values over several lines.
    fn next_value(&mut self, is_array: bool) -> io::Result<Option<Item<'_>>> {
        if let Some(stray) = self.between(is_array)? {
            return Ok(Some(stray));
        }
        if self.rest().is_empty() {
            let is_unclosed = is_array && self.next != Next::Nothing;
            self.next = Next::Nothing;
            return Ok(is_unclosed.then(|| problem(self.line, Problem::Unclosed)));
        }
        if is_array {
            match (self.next, self.rest().first()) {
                (Next::Comma, Some(byte)) => {
                    let found = Problem::NoComma(*byte);
                    self.next = Next::Value;
                    return Ok(Some(problem(self.line, found)));
                }
                (Next::Nothing, _) => {}
                _ => self.next = Next::Comma,
            }
        }
        let mut frame = Frame::default();
        let (mut at, mut skipped) = (0, 0);
        let line = self.line;
        loop {
            if let Some(end) = frame.end(&self.rest()[at..]) {
                let count = at + end;
                self.take(count);
                return Ok(Some(self.lend(line, count, skipped, false)));
            }
            at = self.rest().len();
            if at > MAX_LENGTH {
                skipped += at as u64;
                self.take(at);
                at = 0;
            }
            if !self.fill()? {
                self.take(at);
                return Ok(Some(self.lend(line, at, skipped, true)));
            }
        }
    }

    /// Goes to where the next value begins. What doesn't belong there is told.
    fn between(&mut self, is_array: bool) -> io::Result<Option<Item<'static>>> {
        loop {
            let Some(byte) = self.rest().first().copied() else {
                if self.fill()? {
                    continue;
                }
                return Ok(None);
            };
            let line = self.line;
            match byte {
                b' ' | b'\t' | b'\r' | b'\n' => self.take(1),
                b',' if is_array && self.next == Next::Comma => {
                    self.next = Next::Value;
                    self.take(1);
                }
                b']' if is_array && matches!(self.next, Next::First | Next::Comma) => {
                    self.next = Next::Nothing;
                    self.take(1);
                }
                b',' | b']' | b'}' | b':' => {
                    if is_array && byte == b']' {
                        self.next = Next::Nothing;
                    }
                    self.take(1);
                    return Ok(Some(problem(line, Problem::Stray(byte))));
                }
                _ => return Ok(None),
            }
        }
    }
}

fn problem(line: u64, problem: Problem) -> Item<'static> {
    Item { line, event: Event::Problem(problem) }
}
