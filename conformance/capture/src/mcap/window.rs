//! A buffer that slides over the input, and grows for long records.

use std::io::{self, ErrorKind, Read};

use crc32fast::Hasher;

/// The initial size of the buffer, in bytes. Few records are longer.
const CAPACITY: usize = 64 * 1024;

#[derive(Debug)]
pub(super) struct Window<R> {
    input: R,
    buffer: Vec<u8>,
    /// The index of the cursor in the buffer.
    start: usize,
    /// The buffer index just after the last byte that was read.
    end: usize,
    /// The offset of the cursor in the input.
    offset: u64,
    is_at_end: bool,
    /// The checksum of everything before the latest [`start_part`](Self::start_part) call.
    before: Hasher,
    /// The checksum of the bytes from there to `summed`.
    part: Hasher,
    /// The buffer index just after the last byte in a checksum. The bytes from there to the cursor are added later, in
    /// large pieces: short pieces take much longer per byte.
    summed: usize,
}

impl<R: Read> Window<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            buffer: vec![0; CAPACITY],
            start: 0,
            end: 0,
            offset: 0,
            is_at_end: false,
            before: Hasher::new(),
            part: Hasher::new(),
            summed: 0,
        }
    }

    /// Reads until at least `count` bytes follow the cursor, or the input ends.
    ///
    /// The buffer grows with the available data, not with `count`.
    pub(super) fn require(&mut self, count: usize) -> io::Result<()> {
        while self.end - self.start < count && !self.is_at_end {
            if self.end == self.buffer.len() {
                self.make_room(count);
            }
            match self.input.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.is_at_end = true,
                // A faulty reader could return more than the size of its buffer.
                Ok(read) => self.end = self.buffer.len().min(self.end + read),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Moves the data to the front if that frees half of the buffer; otherwise, grows the buffer. Each byte is
    /// therefore moved once on average.
    fn make_room(&mut self, count: usize) {
        self.sum();
        if self.start > self.buffer.len() / 2 {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            (self.start, self.summed) = (0, 0);
        } else {
            let enough = self.start.saturating_add(count).max(self.buffer.len() + CAPACITY);
            self.buffer.resize(enough.min(self.buffer.len() * 2), 0);
        }
    }

    /// Skips bytes without storing them. Returns the number of skipped bytes.
    pub(super) fn skip(&mut self, count: u64) -> io::Result<u64> {
        let mut left = count;
        while left > 0 {
            self.require(1)?;
            let here = usize::try_from(left).unwrap_or(usize::MAX).min(self.ahead().len());
            if here == 0 {
                break;
            }
            self.advance(here);
            left -= here as u64;
        }
        Ok(count - left)
    }

    /// Moves bytes to `out`. Returns the number of moved bytes.
    pub(super) fn take(&mut self, count: usize, out: &mut Vec<u8>) -> io::Result<usize> {
        out.clear();
        while out.len() < count {
            self.require(1)?;
            let here = (count - out.len()).min(self.ahead().len());
            if here == 0 {
                break;
            }
            out.extend_from_slice(&self.ahead()[..here]);
            self.advance(here);
        }
        Ok(out.len())
    }
}

impl<R> Window<R> {
    /// The buffered bytes after the cursor.
    pub(super) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The `count` bytes before the cursor. These bytes must have been read since the latest [`require`](Self::require)
    /// call.
    pub(super) fn behind(&self, count: usize) -> &[u8] {
        &self.buffer[self.start - count..self.start]
    }

    /// Moves the cursor over bytes in the buffer.
    pub(super) fn advance(&mut self, count: usize) {
        self.start += count;
        self.offset += count as u64;
    }

    /// Adds the bytes before the cursor to the checksum.
    fn sum(&mut self) {
        self.part.update(&self.buffer[self.summed..self.start]);
        self.summed = self.start;
    }

    /// The input, positioned after the bytes that were read.
    pub(super) fn into_input(self) -> R {
        self.input
    }

    /// The offset of the cursor in the input.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// True if the input has no more bytes.
    pub(super) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// The checksum of everything before the cursor.
    pub(super) fn checksum(&mut self) -> u32 {
        self.sum();
        let mut whole = self.before.clone();
        whole.combine(&self.part);
        whole.finalize()
    }

    /// Restarts the partial checksum at the cursor.
    pub(super) fn start_part(&mut self) {
        self.sum();
        self.before.combine(&std::mem::take(&mut self.part));
    }

    /// Restarts both checksums at the cursor.
    pub(super) fn restart(&mut self) {
        (self.before, self.part, self.summed) = (Hasher::new(), Hasher::new(), self.start);
    }

    /// The checksum of the part up to the cursor.
    pub(super) fn part_checksum(&mut self) -> u32 {
        self.sum();
        self.part.clone().finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader that returns a few bytes at a time.
    struct Slow<'b>(&'b [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let end = out.len().min(777);
            self.0.read(&mut out[..end])
        }
    }

    #[test]
    fn preserves_bytes_while_sliding_and_growing() {
        let bytes: Vec<u8> = (0..=250).cycle().take(10 * CAPACITY).collect();
        let mut window = Window::new(Slow(&bytes));
        let mut position = 0;
        for count in [1, 1_000, CAPACITY - 5, 100, 3 * CAPACITY, 7, CAPACITY].into_iter().cycle() {
            window.require(count).expect("a slice");
            let count = count.min(bytes.len() - position);
            assert_eq!(window.ahead()[..count], bytes[position..position + count]);
            window.advance(count);
            assert_eq!(window.behind(count), &bytes[position..position + count]);
            position += count;
            assert_eq!(window.offset(), position as u64);
            if count == 0 {
                break;
            }
        }
        assert!(window.is_at_end());
        assert_eq!((position, window.checksum()), (bytes.len(), crc32fast::hash(&bytes)));
        assert!(window.buffer.len() <= 8 * CAPACITY, "{}", window.buffer.len());
    }

    #[test]
    fn includes_skipped_and_taken_bytes_in_checksums() {
        let bytes: Vec<u8> = (0..=250).cycle().take(5 * CAPACITY).collect();
        let mut window = Window::new(Slow(&bytes));
        let mut out = Vec::new();
        assert_eq!(window.skip(2 * CAPACITY as u64).expect("a slice"), 2 * CAPACITY as u64);
        window.start_part();
        assert_eq!(window.take(CAPACITY, &mut out).expect("a slice"), CAPACITY);
        assert_eq!(out, bytes[2 * CAPACITY..3 * CAPACITY]);
        assert_eq!(window.part_checksum(), crc32fast::hash(&out));
        assert_eq!(window.skip(u64::MAX).expect("a slice"), 2 * CAPACITY as u64);
        assert_eq!(window.take(usize::MAX, &mut out).expect("a slice"), 0);
        assert_eq!(window.checksum(), crc32fast::hash(&bytes));
    }

    #[test]
    fn a_large_request_does_not_grow_the_buffer() {
        let mut window = Window::new(&b"short"[..]);
        window.require(usize::MAX).expect("a slice");
        assert_eq!((window.ahead(), window.buffer.len()), (&b"short"[..], CAPACITY));
    }
}
