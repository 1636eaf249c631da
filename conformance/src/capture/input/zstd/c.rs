//! Decompresses frames with the C library.

use std::io::{self, BufRead, Read};

use zstd::stream::read::Decoder;

/// Decompresses consecutive frames. Other data and truncated frames are errors.
pub(crate) struct Frames<R: BufRead> {
    decoder: Decoder<'static, R>,
    has_started: bool,
}

impl<R: BufRead> Frames<R> {
    pub(crate) fn new(input: R) -> io::Result<Self> {
        Ok(Self { decoder: Decoder::with_buffer(input)?, has_started: false })
    }

    /// The rest of the compressed input.
    pub(crate) fn into_inner(self) -> R {
        self.decoder.finish()
    }
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        // The library requires a frame.
        if !self.has_started && self.decoder.get_mut().fill_buf()?.is_empty() {
            return Ok(0);
        }
        self.has_started = true;
        self.decoder.read(out)
    }
}
