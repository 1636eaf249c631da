//! Decompresses frames with ruzstd, a pure Rust library.

use std::io::{self, BufRead, ErrorKind, Read};

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

use crate::input::padding::skip_zeros;

/// Decompresses consecutive frames. Zeros after a frame are ignored. Other data and truncated frames are errors.
pub(crate) struct Frames<R> {
    input: R,
    decoder: FrameDecoder,
}

impl<R: BufRead> Frames<R> {
    #[allow(clippy::unnecessary_wraps, reason = "the other implementation can fail")]
    pub(crate) fn new(input: R) -> io::Result<Self> {
        Ok(Self { input, decoder: FrameDecoder::new() })
    }

    /// Starts the next frame, after skipping any skippable frames. Returns false at the end of the input.
    fn start(&mut self) -> io::Result<bool> {
        while skip_zeros(&mut self.input)? {
            match self.decoder.reset(&mut self.input) {
                Ok(()) => return Ok(true),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => self.skip(length.into())?,
                Err(error) => return Err(io::Error::other(error)),
            }
        }
        Ok(false)
    }

    fn skip(&mut self, length: u64) -> io::Result<()> {
        let skipped = io::copy(&mut self.input.by_ref().take(length), &mut io::sink())?;
        if skipped < length {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "a zstd frame is truncated"));
        }
        Ok(())
    }

    /// Verifies the checksum of a completed frame, if the frame has one.
    fn verify(&self) -> io::Result<()> {
        let (stated, found) = (self.decoder.get_checksum_from_data(), self.decoder.get_calculated_checksum());
        if stated.is_some() && stated != found {
            let text = "the content of a zstd frame doesn't match its checksum";
            return Err(io::Error::new(ErrorKind::InvalidData, text));
        }
        Ok(())
    }
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.decoder.read(out)?;
            if read > 0 || out.is_empty() {
                return Ok(read);
            }
            if self.decoder.is_finished() {
                self.verify()?;
                if !self.start()? {
                    return Ok(0);
                }
            }
            if !self.decoder.is_finished() {
                let room = BlockDecodingStrategy::UptoBytes(out.len());
                self.decoder.decode_blocks(&mut self.input, room).map_err(io::Error::other)?;
            }
        }
    }
}
