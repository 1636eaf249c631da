//! Decompresses frames with the C library.

use std::io::{self, BufRead, ErrorKind, Read};

use zstd::stream::raw::{Decoder, InBuffer, Operation, OutBuffer};

use crate::input::padding::skip_zeros;

/// Decompresses consecutive frames. Zeros after a frame are ignored. Other data and truncated frames are errors.
pub(crate) struct Frames<R> {
    input: R,
    decoder: Decoder<'static>,
    /// True between the first and the last byte of a frame.
    is_in_frame: bool,
    /// The number of bytes that the decoder needs for its next step. If the decoder got more bytes, an error would hide
    /// the output of the bytes before the error.
    needed: usize,
    /// True if the decoder may have more output than fitted into the buffer. This output is returned before more input
    /// is read.
    is_full: bool,
}

/// The number of bytes at the start of a frame that determine the length of its header.
const START: usize = 5;

impl<R: BufRead> Frames<R> {
    /// Decompresses this input.
    pub(crate) fn new(input: R) -> io::Result<Self> {
        Ok(Self { input, decoder: Decoder::new()?, is_in_frame: false, needed: START, is_full: false })
    }

    /// Decompresses a part of the current frame. Returns the number of bytes.
    fn step(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let ahead = self.input.fill_buf()?;
        let is_at_end = ahead.is_empty();
        let size = out.len();
        let ahead = if self.is_full { &[] } else { &ahead[..ahead.len().min(self.needed)] };
        let (mut packed, mut unpacked) = (InBuffer::around(ahead), OutBuffer::around(out));
        self.needed = self.decoder.run(&mut packed, &mut unpacked)?;
        self.is_in_frame = self.needed > 0;
        let (read, written) = (packed.pos(), unpacked.pos());
        self.is_full = written == size;
        self.input.consume(read);
        if is_at_end && written == 0 && self.is_in_frame {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "unexpected end of file"));
        }
        Ok(written)
    }
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while !out.is_empty() {
            if !self.is_in_frame {
                if !skip_zeros(&mut self.input)? {
                    break;
                }
                self.decoder.reinit()?;
                (self.is_in_frame, self.needed) = (true, START);
            }
            let written = self.step(out)?;
            if written > 0 {
                return Ok(written);
            }
        }
        Ok(0)
    }
}
