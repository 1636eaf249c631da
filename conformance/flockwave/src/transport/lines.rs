//! Splits a stream into lines.

use memchr::memchr;

/// A line of a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line without its line end (a line feed, or a carriage return and a line feed).
    Whole(Vec<u8>),
    /// A line that was longer than the limit, and was dropped.
    TooLong,
}

/// A buffer that splits received pieces into lines.
#[derive(Debug)]
pub struct Lines {
    /// The maximum length of a line.
    limit: usize,
    buffer: Vec<u8>,
    /// The start of the first line that hasn't been returned yet.
    start: usize,
    /// The index up to which the buffer contains no line end.
    searched: usize,
    /// True while skipping the rest of a line that is too long.
    is_skipping: bool,
}

impl Lines {
    /// Creates an empty buffer for lines up to this length.
    pub fn new(limit: usize) -> Self {
        Self { limit, buffer: Vec::new(), start: 0, searched: 0, is_skipping: false }
    }

    /// Adds received bytes.
    pub fn feed(&mut self, bytes: &[u8]) {
        if self.start > 0 {
            self.buffer.drain(..self.start);
            self.searched -= self.start;
            self.start = 0;
        }
        self.buffer.extend_from_slice(bytes);
    }

    /// The next complete line.
    pub fn take(&mut self) -> Option<Line> {
        let Some(found) = memchr(b'\n', &self.buffer[self.searched..]) else {
            self.searched = self.buffer.len();
            if self.start == self.buffer.len() {
                self.release();
            }
            return self.drop_excess();
        };
        let end = self.searched + found;
        let line = &self.buffer[self.start..end];
        let is_too_long = line.len() > self.limit;
        let line = Line::Whole(line.strip_suffix(b"\r").unwrap_or(line).to_vec());
        (self.start, self.searched) = (end + 1, end + 1);
        if std::mem::take(&mut self.is_skipping) {
            return self.take();
        }
        Some(if is_too_long { Line::TooLong } else { line })
    }

    /// All complete lines.
    pub fn taken(&mut self) -> Vec<Line> {
        std::iter::from_fn(|| self.take()).collect()
    }

    /// The memory of received bytes, in bytes; at least 1 while the rest of a line that is too long is skipped.
    pub fn capacity(&self) -> usize {
        self.buffer.capacity().max(usize::from(self.is_skipping))
    }

    /// Drops an incomplete line.
    pub fn drop_rest(&mut self) {
        *self = Self::new(self.limit);
    }

    /// Returns an incomplete line; empty if there is none, or if its start was dropped.
    pub(crate) fn take_rest(&mut self) -> Vec<u8> {
        let known = std::mem::replace(self, Self::new(self.limit));
        if known.is_skipping { Vec::new() } else { known.buffer[known.start..].to_vec() }
    }

    /// Releases the memory of the buffer, whose lines have all been returned.
    fn release(&mut self) {
        self.buffer = Vec::new();
        (self.start, self.searched) = (0, 0);
    }

    fn drop_excess(&mut self) -> Option<Line> {
        if self.is_skipping {
            *self = Self { is_skipping: true, ..Self::new(self.limit) };
            return None;
        }
        if self.buffer.len() - self.start <= self.limit {
            return None;
        }
        *self = Self { is_skipping: true, ..Self::new(self.limit) };
        Some(Line::TooLong)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::transport::MESSAGE_LIMIT;

    fn whole(text: &str) -> Line {
        Line::Whole(text.as_bytes().to_vec())
    }

    #[test]
    fn returns_a_rest_that_is_whole() {
        let mut lines = Lines::new(6);
        lines.feed(b"one\ntwo");
        assert_eq!(lines.taken(), [whole("one")]);
        assert_eq!((lines.take_rest(), lines.capacity()), (b"two".to_vec(), 0));
        lines.feed(b"too long");
        assert_eq!((lines.taken(), lines.take_rest()), (vec![Line::TooLong], vec![]));
    }

    #[test]
    fn accepts_both_line_ends_and_keeps_incomplete_lines() {
        let mut lines = Lines::new(MESSAGE_LIMIT);
        lines.feed(b"one\r\n\ntw");
        assert_eq!(lines.taken(), [whole("one"), whole("")]);
        assert!(lines.capacity() > 0);
        lines.feed(b"o\n");
        assert_eq!(lines.taken(), [whole("two")]);
        assert_eq!(lines.capacity(), 0);
    }

    #[test]
    fn drops_an_endless_line() {
        let mut lines = Lines::new(MESSAGE_LIMIT);
        let piece = vec![b'x'; 1 << 20];
        let mut found = Vec::new();
        for _ in 0..40 {
            lines.feed(&piece);
            found.extend(lines.taken());
            assert!(lines.buffer.len() <= MESSAGE_LIMIT + piece.len());
        }
        lines.feed(b"\nnext\n");
        found.extend(lines.taken());
        assert_eq!(found, [Line::TooLong, whole("next")]);
    }

    #[test]
    fn limits_lines_within_a_single_piece() {
        let mut lines = Lines::new(MESSAGE_LIMIT);
        let mut text = vec![b'x'; MESSAGE_LIMIT + 1];
        text.extend(b"\nnext\n");
        lines.feed(&text);
        assert_eq!(lines.taken(), [Line::TooLong, whole("next")]);
    }

    proptest! {
        #[test]
        fn reads_a_stream_split_anywhere(
            pieces in prop::collection::vec(prop::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..20), 0..20)
        ) {
            let whole = pieces.concat();
            let mut in_one_piece = Lines::new(MESSAGE_LIMIT);
            in_one_piece.feed(&whole);
            let expected = in_one_piece.taken();
            let mut lines = Lines::new(MESSAGE_LIMIT);
            let mut found = Vec::new();
            for piece in &pieces {
                lines.feed(piece);
                found.extend(lines.taken());
            }
            prop_assert_eq!(found, expected);
        }
    }
}
