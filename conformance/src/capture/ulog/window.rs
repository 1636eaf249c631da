//! A buffer that slides over what is read.

use std::io::{self, ErrorKind, Read};

/// Bytes of the buffer: what is needed ahead, and about as much again, so that the bytes that are kept are
/// moved at most about once for each byte read. Half of it and more is in the second cache of most machines.
pub(super) const CAPACITY: usize = 512 * 1024;

#[derive(Debug)]
pub(super) struct Window<R> {
    input: R,
    buffer: Box<[u8]>,
    /// Where in the buffer the cursor is.
    start: usize,
    /// Where in the buffer the bytes end that were read.
    end: usize,
    /// Where in the input the cursor is.
    offset: u64,
    is_at_end: bool,
}

impl<R: Read> Window<R> {
    pub(super) fn new(input: R) -> Self {
        let buffer = vec![0; CAPACITY].into_boxed_slice();
        Self { input, buffer, start: 0, end: 0, offset: 0, is_at_end: false }
    }

    /// Reads until `count` bytes are behind the cursor, if there are so many.
    pub(super) fn require(&mut self, count: usize) -> io::Result<()> {
        debug_assert!(count <= CAPACITY, "more is asked for than the buffer holds");
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
                // No implementation should claim more than the room that it had; none is believed.
                Ok(read) => self.end = self.buffer.len().min(self.end + read),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl<R> Window<R> {
    /// What was read and is behind the cursor.
    #[inline]
    pub(super) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The last `count` bytes before the cursor, since the last call of [`require`](Self::require).
    #[inline]
    pub(super) fn behind(&self, count: usize) -> &[u8] {
        &self.buffer[self.start - count..self.start]
    }

    /// Moves the cursor over bytes that were read.
    #[inline]
    pub(super) fn advance(&mut self, count: usize) {
        debug_assert!(count <= self.end - self.start, "bytes that weren't read are passed");
        self.start += count;
        self.offset += count as u64;
    }

    /// Where in the input the cursor is.
    #[inline]
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// Whether nothing follows what was read.
    pub(super) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// Bytes of the buffer.
    pub(super) fn capacity(&self) -> usize {
        self.buffer.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_keep_their_order_while_the_window_slides() {
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
