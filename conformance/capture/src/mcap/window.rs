//! A window over a file, with checksums of the bytes before the cursor.

use std::io::{self, Read};
use std::mem;

use crc32fast::Hasher;

/// The initial size of the buffer, in bytes. Few records are longer.
const CAPACITY: usize = 64 * 1024;

#[derive(Debug)]
pub(super) struct Window<R> {
    bytes: crate::window::Window<R>,
    /// The checksum of everything before the latest [`start_part`](Self::start_part) call.
    before: Hasher,
    /// The checksum of the bytes from the latest `start_part` call to `summed`.
    part: Hasher,
    /// The offset just after the last byte in a checksum. The bytes after this offset, up to the cursor, are added
    /// later in large pieces: short pieces take much longer per byte.
    summed: u64,
}

impl<R: Read> Window<R> {
    pub(super) fn new(input: R) -> Self {
        let bytes = crate::window::Window::new(input, CAPACITY);
        Self { bytes, before: Hasher::new(), part: Hasher::new(), summed: 0 }
    }

    /// Reads until at least `count` bytes follow the cursor, or the input ends.
    pub(super) fn require(&mut self, count: usize) -> io::Result<()> {
        if self.ahead().len() < count {
            self.sum();
        }
        self.bytes.require(count)
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

    /// Takes bytes. There are fewer than `count` if the input ends.
    pub(super) fn take(&mut self, count: usize) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        while out.len() < count {
            self.require(1)?;
            let here = (count - out.len()).min(self.ahead().len());
            if here == 0 {
                break;
            }
            out.extend_from_slice(&self.ahead()[..here]);
            self.advance(here);
        }
        Ok(out)
    }
}

impl<R> Window<R> {
    /// The buffered bytes after the cursor.
    pub(super) fn ahead(&self) -> &[u8] {
        self.bytes.ahead()
    }

    /// The `count` bytes before the cursor. These bytes must have been read since the latest [`require`](Self::require)
    /// call.
    pub(super) fn behind(&self, count: usize) -> &[u8] {
        self.bytes.behind(count)
    }

    /// Moves the cursor over bytes in the buffer.
    pub(super) fn advance(&mut self, count: usize) {
        self.bytes.advance(count);
    }

    /// Adds the bytes before the cursor to the checksum.
    fn sum(&mut self) {
        // The bytes are still in the buffer, so their number fits into a `usize`.
        let count = usize::try_from(self.offset() - self.summed).unwrap_or_default();
        self.part.update(self.bytes.behind(count));
        self.summed = self.offset();
    }

    /// The offset of the cursor in the input.
    pub(super) fn offset(&self) -> u64 {
        self.bytes.offset()
    }

    /// True if the input has no more bytes.
    pub(super) fn is_at_end(&self) -> bool {
        self.bytes.is_at_end()
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
        self.before.combine(&mem::take(&mut self.part));
    }

    /// Restarts both checksums at the cursor.
    pub(super) fn restart(&mut self) {
        (self.before, self.part, self.summed) = (Hasher::new(), Hasher::new(), self.offset());
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

    #[test]
    fn includes_skipped_and_taken_bytes_in_checksums() {
        let bytes: Vec<u8> = (0..=250).cycle().take(5 * CAPACITY).collect();
        let mut window = Window::new(&bytes[..]);
        assert_eq!(window.skip(2 * CAPACITY as u64).expect("a slice"), 2 * CAPACITY as u64);
        window.start_part();
        let taken = window.take(CAPACITY).expect("a slice");
        assert_eq!(taken, bytes[2 * CAPACITY..3 * CAPACITY]);
        assert_eq!(window.part_checksum(), crc32fast::hash(&taken));
        assert_eq!(window.skip(u64::MAX).expect("a slice"), 2 * CAPACITY as u64);
        assert_eq!(window.take(usize::MAX).expect("a slice"), b"");
        assert_eq!(window.checksum(), crc32fast::hash(&bytes));
    }
}
