//! Splits JSON input into values: JSON Lines, an array, or one or more values that may span lines. The text of each
//! value is borrowed from the reader's buffer and isn't parsed.
//!
//! The form is detected from the content. Input that starts with `[` is an array of values. If the first line ends
//! within a value and the second line doesn't start another value, values may span lines. All other input is JSON
//! Lines, in which an invalid line doesn't affect the other lines.

use std::fmt;
use std::io::{self, Read};

use uavspec_model::Extent;
use uavspec_model::json::Frame;

use crate::window::Window;

/// The maximum length of a value, in bytes. Real messages are much shorter.
pub const MAX_LENGTH: usize = 16 << 20;

/// The initial size of the buffer, in bytes.
const CAPACITY: usize = 1 << 16;

/// The byte order mark in UTF-8.
const BOM: &[u8] = b"\xef\xbb\xbf";

/// A value or a problem, with its location.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item<'r> {
    /// The line on which the value or problem starts, from 1.
    pub line: u64,
    /// The value or problem.
    pub event: Event<'r>,
}

/// An event in JSON input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'r> {
    /// The text of a value. The text may be invalid JSON.
    Value {
        /// The bytes.
        bytes: &'r [u8],
        /// True if the input ends directly after the value, without a newline or separator.
        is_last: bool,
        /// True if the value is an element of an array.
        is_element: bool,
    },
    /// An unreadable part.
    Problem(Problem),
}

/// A problem in JSON input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// The input starts with a byte order mark.
    ByteOrderMark,
    /// A value that is longer than [`MAX_LENGTH`] was skipped.
    TooLong {
        /// The length of the value, in bytes.
        length: u64,
    },
    /// A comma or a closing bracket in place of a value.
    Stray(u8),
    /// A missing comma between two array elements. Contains the byte found instead.
    NoComma(u8),
    /// An unclosed array.
    Unclosed,
}

impl Problem {
    /// The extent to which the input can be read despite this problem.
    pub fn extent(&self) -> Extent {
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
                .write_str("invalid JSON: byte order mark at the start (forbidden by RFC 8259, section 8.1)"),
            Self::TooLong { length } => {
                write!(formatter, "skipped a value of {length} bytes: the limit is {MAX_LENGTH} bytes")
            }
            Self::Stray(byte) => write!(formatter, "expected a value, found `{}`", byte.escape_ascii()),
            Self::NoComma(byte) => write!(formatter, "expected a comma, found `{}`", byte.escape_ascii()),
            Self::Unclosed => formatter.write_str("the array is not closed"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// One value on each line.
    Lines,
    /// Values that may span lines.
    Values,
    /// The elements of an array.
    Array,
}

/// Splits input into values.
#[derive(Debug)]
pub struct Reader<R> {
    /// The cursor is at the first byte that hasn't been returned yet.
    window: Window<R>,
    mode: Option<Mode>,
    /// The line at the cursor.
    line: u64,
    /// The last byte that was read.
    last: Option<u8>,
    /// The next expected item of an array.
    next: Next,
}

/// The next expected item of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// The first value, or the end.
    First,
    Value,
    /// A comma, or the end.
    Comma,
    /// Nothing, since the array is closed.
    Nothing,
}

impl<R: Read> Reader<R> {
    /// Creates a reader at the start of the input.
    pub fn new(input: R) -> Self {
        Self { window: Window::new(input, CAPACITY), mode: None, line: 1, last: None, next: Next::First }
    }

    /// The number of bytes read.
    pub fn bytes(&self) -> u64 {
        self.window.offset() + self.rest().len() as u64
    }

    /// The number of lines read so far.
    pub fn lines(&self) -> u64 {
        // The last line may lack a newline.
        self.line - 1 + u64::from(self.last.is_some_and(|byte| byte != b'\n'))
    }

    /// The next value or problem; `None` at the end.
    #[allow(clippy::should_implement_trait)] // an iterator's items can't borrow from it
    pub fn next(&mut self) -> io::Result<Option<Item<'_>>> {
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
        self.window.ahead()
    }

    /// Reads more. Returns false at the end of the input.
    fn fill(&mut self) -> io::Result<bool> {
        // Reads larger values in larger pieces, to limit the cost of moving data.
        let has_read = self.window.read(2 * self.rest().len() + 1)?;
        self.last = self.rest().last().copied().or(self.last);
        Ok(has_read)
    }

    /// Consumes bytes.
    fn take(&mut self, count: usize) {
        self.take_lines(count, memchr::memchr_iter(b'\n', &self.rest()[..count]).count() as u64);
    }

    /// Consumes `count` bytes, which contain `lines` newlines.
    fn take_lines(&mut self, count: usize, lines: u64) {
        self.line += lines;
        self.window.advance(count);
    }

    fn begins_with_mark(&mut self) -> io::Result<bool> {
        while self.rest().len() < BOM.len() && self.fill()? {}
        let is_marked = self.rest().starts_with(BOM);
        if is_marked {
            self.take(BOM.len());
        }
        Ok(is_marked)
    }

    /// Detects the form of the input from its first line and the start of the second line.
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

    /// Reads the next value from JSON Lines.
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
                self.window.advance(seen);
                seen = 0;
            }
            if !self.fill()? {
                if skipped == 0 && self.rest().trim_ascii().is_empty() {
                    self.window.advance(self.rest().len());
                    return Ok(None);
                }
                break (self.rest().len(), true);
            }
        };
        let line = self.line;
        self.take_lines(end, u64::from(!is_last));
        Ok(Some(self.lend(line, end, skipped, is_last)))
    }

    /// Returns the most recently consumed bytes, or a problem if the value was too long.
    fn lend(&self, line: u64, count: usize, skipped: u64, is_last: bool) -> Item<'_> {
        let bytes = self.window.behind(count).trim_ascii();
        if skipped > 0 || bytes.len() > MAX_LENGTH {
            let length = skipped + bytes.len() as u64;
            return problem(line, Problem::TooLong { length });
        }
        Item { line, event: Event::Value { bytes, is_last, is_element: self.mode == Some(Mode::Array) } }
    }

    /// Reads a value that may span lines.
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

    /// Skips to the start of the next value, and reports unexpected bytes.
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
