//! A buffer that slides over the input.

use std::io::{self, ErrorKind, Read};

/// The size of the buffer: about twice the lookahead. Each byte is therefore moved about once. The buffer fits into the
/// L2 cache of most machines.
pub(super) const CAPACITY: usize = 512 * 1024;

#[derive(Debug)]
pub(super) struct Window<R> {
    input: R,
    buffer: Box<[u8]>,
    /// The index of the cursor in the buffer.
    start: usize,
    /// The buffer index just after the last byte that was read.
    end: usize,
    /// The offset of the cursor in the input.
    offset: u64,
    is_at_end: bool,
}

impl<R: Read> Window<R> {
    pub(super) fn new(input: R) -> Self {
        let buffer = vec![0; CAPACITY].into_boxed_slice();
        Self { input, buffer, start: 0, end: 0, offset: 0, is_at_end: false }
    }

    /// Reads until at least `count` bytes follow the cursor, or the input ends.
    pub(super) fn require(&mut self, count: usize) -> io::Result<()> {
        debug_assert!(count <= CAPACITY, "`count` exceeds the size of the buffer");
        if self.end - self.start >= count || self.is_at_end {
            return Ok(());
        }
        if self.start + count > self.buffer.len() {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        while self.end - self.start < count && !self.is_at_end {
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
}

impl<R> Window<R> {
    /// The buffered bytes after the cursor.
    #[inline]
    pub(super) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The `count` bytes before the cursor. These bytes must have been read since the latest [`require`](Self::require)
    /// call.
    #[inline]
    pub(super) fn behind(&self, count: usize) -> &[u8] {
        &self.buffer[self.start - count..self.start]
    }

    /// Moves the cursor over bytes in the buffer.
    #[inline]
    pub(super) fn advance(&mut self, count: usize) {
        debug_assert!(count <= self.end - self.start, "the bytes haven't been read");
        self.start += count;
        self.offset += count as u64;
    }

    /// The offset of the cursor in the input.
    #[inline]
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// True if the input has no more bytes.
    pub(super) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// The size of the buffer, in bytes.
    pub(super) fn capacity(&self) -> usize {
        self.buffer.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preserves_bytes_while_sliding() {
        let bytes: Vec<u8> = (0..=250).cycle().take(3 * CAPACITY).collect();
        let mut window = Window::new(&bytes[..]);
        let mut position = 0;
        for count in [1, 1_000, 65_538, 100, 300_000, CAPACITY, 7].into_iter().cycle() {
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
        assert_eq!((position, window.capacity()), (bytes.len(), CAPACITY));
    }
}
