//! Decompresses zstd frames (RFC 8878) as they are read. A file may contain several consecutive frames: `cat`, parallel
//! compressors and seekable formats create such files.

#[cfg(feature = "zstd")]
mod c;
#[cfg(any(test, not(feature = "zstd")))]
mod rust;

use std::io::{self, BufRead, Read};

#[cfg(feature = "zstd")]
pub(crate) use self::c::Frames;
#[cfg(not(feature = "zstd"))]
pub(crate) use self::rust::Frames;

/// The first bytes of a frame.
pub const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// The first bytes of a skippable frame. The lower four bits of the first byte are arbitrary.
const SKIPPED: [u8; 4] = [0x50, 0x2a, 0x4d, 0x18];

/// Decompresses consecutive frames. Zeros after a frame are ignored. Other data and truncated frames are errors.
pub fn decompress(input: impl BufRead) -> io::Result<impl Read> {
    Frames::new(input)
}

/// True if these bytes start with a frame, including a skippable one.
pub(super) fn is_frame(start: &[u8]) -> bool {
    let is_skipped = || matches!(start, [first, rest @ ..] if first & 0xf0 == SKIPPED[0] && rest.starts_with(&SKIPPED[1..]));
    start.starts_with(&MAGIC) || is_skipped()
}

#[cfg(test)]
mod tests {
    use std::io::{self, Read};

    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    /// Decompresses frames with each implementation, and asserts that their results are equal.
    fn decompressed(input: &[u8]) -> io::Result<Vec<u8>> {
        let read = |frames: &mut dyn Read| {
            let mut bytes = Vec::new();
            frames.read_to_end(&mut bytes).map(|_| bytes)
        };
        let found = read(&mut Frames::new(input)?);
        assert_eq!(found.as_ref().ok(), read(&mut rust::Frames::new(input)?).ok().as_ref());
        found
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    #[test]
    fn reads_consecutive_frames() {
        let (first, second) = (b"one ".repeat(50_000), b"two".repeat(7));
        let skipped = b"\x5a\x2a\x4d\x18\x03\0\0\0abc".to_vec();
        let packed = [
            skipped.clone(),
            zstd(&first),
            skipped.clone(),
            zstd(b""),
            vec![0; 9],
            zstd(&second),
            skipped,
            vec![0],
        ];
        assert_eq!(decompressed(&packed.concat()).expect("frames"), [&first[..], &second].concat());
        assert_eq!(decompressed(b"").expect("no frame"), b"");
    }

    #[test]
    fn reports_invalid_data_after_a_frame() {
        let packed = zstd(b"text");
        for rest in [
            &b"no frame"[..],
            b"\0\0\x28",
            &MAGIC[..2],
            &zstd(b"more")[..7],
            b"\x50\x2a\x4d\x18\x09\0\0\0abc",
        ] {
            assert!(decompressed(&[&packed[..], rest].concat()).is_err(), "{}", rest.escape_ascii());
        }
    }

    #[test]
    fn reports_a_wrong_checksum() {
        let mut packed = zstd(&b"wind ".repeat(1_000));
        // The frame ends with its checksum.
        *packed.last_mut().expect("bytes") ^= 1;
        let error = decompressed(&packed).expect_err("a wrong checksum");
        assert!(error.to_string().contains("checksum"), "{error}");
        let mut frames = rust::Frames::new(&packed[..]).expect("a decoder");
        let error = io::copy(&mut frames, &mut io::sink()).expect_err("a wrong checksum");
        assert_eq!(error.kind(), io::ErrorKind::InvalidData, "{error}");
    }
}
