//! Frames of zstd (RFC 8878), unpacked as they are read. Frames may follow each other: `cat` makes such files of
//! several, and so do packers that use all processors, or that let readers jump.

use std::io::{self, BufRead, ErrorKind, Read};

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// How a frame begins.
pub(crate) const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// How a frame begins that is to be skipped, but for the lower half of its first byte, which is free.
const SKIPPED: [u8; 4] = [0x50, 0x2a, 0x4d, 0x18];

/// Whether bytes begin as a frame does, be it one that is skipped.
pub(super) fn is_frame(start: &[u8]) -> bool {
    let is_skipped = || matches!(start, [first, rest @ ..] if first & 0xf0 == SKIPPED[0] && rest.starts_with(&SKIPPED[1..]));
    start.starts_with(&MAGIC) || is_skipped()
}

/// Reads what frames hold, one after the other. What is no frame, and a frame that is cut off, is an error.
pub(crate) struct Frames<R> {
    packed: R,
    decoder: FrameDecoder,
}

impl<R: BufRead> Frames<R> {
    pub(crate) fn new(packed: R) -> Self {
        Self { packed, decoder: FrameDecoder::new() }
    }

    /// The rest of what is packed.
    pub(crate) fn into_inner(self) -> R {
        self.packed
    }

    /// Starts the next frame, and passes over those that are to be skipped; whether there is one.
    fn start(&mut self) -> io::Result<bool> {
        while !self.packed.fill_buf()?.is_empty() {
            match self.decoder.reset(&mut self.packed) {
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
        let skipped = io::copy(&mut self.packed.by_ref().take(length), &mut io::sink())?;
        if skipped < length {
            return Err(io::Error::new(ErrorKind::UnexpectedEof, "a frame of zstd is cut off"));
        }
        Ok(())
    }

    /// Compares the checksum of a frame that is over, where it has one.
    fn verify(&self) -> io::Result<()> {
        let (stated, found) = (self.decoder.get_checksum_from_data(), self.decoder.get_calculated_checksum());
        if stated.is_some() && stated != found {
            let text = "the checksum of a frame of zstd is not that of what it holds";
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
                self.decoder.decode_blocks(&mut self.packed, room).map_err(io::Error::other)?;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    fn unpacked(packed: &[u8]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Frames::new(packed).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    #[test]
    fn frames_follow_each_other() {
        let (first, second) = (b"one ".repeat(50_000), b"two".repeat(7));
        let skipped = b"\x5a\x2a\x4d\x18\x03\0\0\0abc".to_vec();
        let packed = [skipped.clone(), zstd(&first), skipped.clone(), zstd(b""), zstd(&second), skipped];
        assert_eq!(unpacked(&packed.concat()).expect("frames"), [&first[..], &second].concat());
        assert_eq!(unpacked(b"").expect("no frame"), b"");
    }

    #[test]
    fn reports_data_after_a_frame() {
        let packed = zstd(b"text");
        for rest in
            [&b"no frame"[..], &[0; 8], &MAGIC[..2], &zstd(b"more")[..7], b"\x50\x2a\x4d\x18\x09\0\0\0abc"]
        {
            assert!(unpacked(&[&packed[..], rest].concat()).is_err(), "{}", rest.escape_ascii());
        }
    }

    #[test]
    fn a_checksum_is_compared() {
        let mut packed = zstd(&b"wind ".repeat(1_000));
        // It is the last of a frame.
        *packed.last_mut().expect("bytes") ^= 1;
        let error = unpacked(&packed).expect_err("another checksum");
        assert_eq!(error.kind(), ErrorKind::InvalidData, "{error}");
    }
}
