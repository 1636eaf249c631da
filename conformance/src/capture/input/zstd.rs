//! Decompresses zstd frames (RFC 8878) as they are read. A file may contain several consecutive frames: `cat`, parallel
//! compressors and seekable formats create such files.

use std::io::{self, BufRead, ErrorKind, Read};

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// The first bytes of a frame.
pub(crate) const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// The first bytes of a skippable frame. The lower four bits of the first byte are arbitrary.
const SKIPPED: [u8; 4] = [0x50, 0x2a, 0x4d, 0x18];

/// True if these bytes start with a frame, including a skippable one.
pub(super) fn is_frame(start: &[u8]) -> bool {
    let is_skipped = || matches!(start, [first, rest @ ..] if first & 0xf0 == SKIPPED[0] && rest.starts_with(&SKIPPED[1..]));
    start.starts_with(&MAGIC) || is_skipped()
}

/// Decompresses consecutive frames. Other data and truncated frames are errors.
pub(crate) struct Frames<R> {
    input: R,
    decoder: FrameDecoder,
}

impl<R: BufRead> Frames<R> {
    pub(crate) fn new(input: R) -> Self {
        Self { input, decoder: FrameDecoder::new() }
    }

    /// The rest of the compressed input.
    pub(crate) fn into_inner(self) -> R {
        self.input
    }

    /// Starts the next frame, after skipping any skippable frames. Returns false at the end of the input.
    fn start(&mut self) -> io::Result<bool> {
        while !self.input.fill_buf()?.is_empty() {
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

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    fn decompressed(input: &[u8]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Frames::new(input).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    #[test]
    fn reads_consecutive_frames() {
        let (first, second) = (b"one ".repeat(50_000), b"two".repeat(7));
        let skipped = b"\x5a\x2a\x4d\x18\x03\0\0\0abc".to_vec();
        let packed = [skipped.clone(), zstd(&first), skipped.clone(), zstd(b""), zstd(&second), skipped];
        assert_eq!(decompressed(&packed.concat()).expect("frames"), [&first[..], &second].concat());
        assert_eq!(decompressed(b"").expect("no frame"), b"");
    }

    #[test]
    fn reports_invalid_data_after_a_frame() {
        let packed = zstd(b"text");
        for rest in
            [&b"no frame"[..], &[0; 8], &MAGIC[..2], &zstd(b"more")[..7], b"\x50\x2a\x4d\x18\x09\0\0\0abc"]
        {
            assert!(decompressed(&[&packed[..], rest].concat()).is_err(), "{}", rest.escape_ascii());
        }
    }

    #[test]
    fn reports_a_wrong_checksum() {
        let mut packed = zstd(&b"wind ".repeat(1_000));
        // The frame ends with its checksum.
        *packed.last_mut().expect("bytes") ^= 1;
        let error = decompressed(&packed).expect_err("a wrong checksum");
        assert_eq!(error.kind(), ErrorKind::InvalidData, "{error}");
    }
}
