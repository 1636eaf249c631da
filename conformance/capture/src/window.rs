//! A buffer that slides over the input, and grows for long records.

use std::io::{self, ErrorKind, Read};

#[derive(Debug)]
pub(crate) struct Window<R> {
    input: R,
    buffer: Vec<u8>,
    /// The index of the cursor in the buffer.
    start: usize,
    /// The buffer index just after the last byte that was read.
    end: usize,
    /// The offset of the cursor in the input.
    offset: u64,
    is_at_end: bool,
}

impl<R: Read> Window<R> {
    /// A window whose buffer initially has this size.
    pub(crate) fn new(input: R, capacity: usize) -> Self {
        Self { input, buffer: vec![0; capacity], start: 0, end: 0, offset: 0, is_at_end: false }
    }

    /// Reads until at least `count` bytes follow the cursor, or the input ends.
    pub(crate) fn require(&mut self, count: usize) -> io::Result<()> {
        while self.ahead().len() < count && self.read(count)? {}
        Ok(())
    }

    /// Calls the input's `read` once. The buffer then has room for `count` bytes after the cursor, if that many are
    /// available. Returns false at the end of the input.
    ///
    /// The buffer grows with the available data, not with `count`.
    pub(crate) fn read(&mut self, count: usize) -> io::Result<bool> {
        if self.is_at_end {
            return Ok(false);
        }
        if self.start > 0 && count > self.buffer.len() - self.start {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        // A third of the buffer stays free. Otherwise, all bytes would be moved again for each short record.
        let enough = self.buffer.len() / 3 * 2;
        if count > enough && self.end > enough {
            self.buffer.resize(self.buffer.len().min(count) * 2, 0);
        }
        let read = loop {
            match self.input.read(&mut self.buffer[self.end..]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        // A faulty reader could return more than the size of its buffer.
        self.end = self.buffer.len().min(self.end + read);
        self.is_at_end = read == 0;
        Ok(!self.is_at_end)
    }
}

impl<R> Window<R> {
    /// The buffered bytes after the cursor.
    #[inline]
    pub(crate) fn ahead(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The `count` bytes before the cursor. These bytes must have been read since the latest [`require`](Self::require)
    /// call.
    #[inline]
    pub(crate) fn behind(&self, count: usize) -> &[u8] {
        &self.buffer[self.start - count..self.start]
    }

    /// Moves the cursor over bytes in the buffer.
    #[inline]
    pub(crate) fn advance(&mut self, count: usize) {
        debug_assert!(count <= self.end - self.start, "the bytes haven't been read");
        self.start += count;
        self.offset += count as u64;
    }

    /// The offset of the cursor in the input.
    #[inline]
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// True if the input has no more bytes.
    pub(crate) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// The size of the buffer, in bytes.
    pub(crate) fn capacity(&self) -> usize {
        self.buffer.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPACITY: usize = 1 << 16;

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
        let mut window = Window::new(Slow(&bytes), CAPACITY);
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
        assert_eq!((window.is_at_end(), position), (true, bytes.len()));
        assert!(window.capacity() <= 6 * CAPACITY, "twice the longest request");
    }

    #[test]
    fn short_steps_after_a_long_request_read_long_parts() {
        /// Counts the calls.
        struct Counting(usize);

        impl Read for Counting {
            fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
                self.0 += 1;
                Ok(out.len())
            }
        }

        let mut window = Window::new(Counting(0), CAPACITY);
        for _ in 0..1_000 {
            window.require(3 * CAPACITY).expect("bytes");
            window.advance(30);
        }
        assert!(window.input.0 < 10, "{} calls", window.input.0);
    }

    #[test]
    fn a_large_request_does_not_grow_the_buffer() {
        let mut window = Window::new(&b"short"[..], CAPACITY);
        window.require(usize::MAX).expect("a slice");
        assert_eq!((window.ahead(), window.capacity()), (&b"short"[..], CAPACITY));
    }
}
