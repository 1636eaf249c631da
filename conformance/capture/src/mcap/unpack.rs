//! Decompresses chunks as they are read.

use std::io::{self, Cursor, Read};

use lz4_flex::frame::FrameDecoder as Lz4;

use crate::input::zstd::Frames as Zstd;

/// The compression of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// zstd.
    Zstd,
    /// LZ4.
    Lz4,
}

impl Packing {
    /// Finds a compression by its name, which must not be empty.
    pub(super) fn from_name(name: &[u8]) -> Option<Self> {
        match name {
            b"zstd" => Some(Self::Zstd),
            b"lz4" => Some(Self::Lz4),
            _ => None,
        }
    }
}

/// The bytes of a compressed chunk.
type Packed = Cursor<Vec<u8>>;

/// Decompresses a chunk. A chunk may consist of several frames.
pub(super) enum Unpacker {
    Zstd(Box<Zstd<Packed>>),
    Lz4(Box<Lz4<Packed>>),
}

impl Unpacker {
    pub(super) fn new(packing: Packing, packed: Vec<u8>) -> io::Result<Self> {
        let packed = Cursor::new(packed);
        Ok(match packing {
            Packing::Zstd => Self::Zstd(Box::new(Zstd::new(packed)?)),
            Packing::Lz4 => Self::Lz4(Box::new(Lz4::new(packed))),
        })
    }
}

impl Read for Unpacker {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Zstd(decoder) => decoder.read(out),
            Self::Lz4(decoder) => read_lz4(decoder, out),
        }
    }
}

fn is_used_up(packed: &Packed) -> bool {
    packed.position() >= packed.get_ref().len() as u64
}

fn read_lz4(decoder: &mut Lz4<Packed>, out: &mut [u8]) -> io::Result<usize> {
    loop {
        let read = decoder.read(out)?;
        if read > 0 || out.is_empty() || is_used_up(decoder.get_ref()) {
            return Ok(read);
        }
        // The frame is complete. A new decoder reads the next frame, since frames may differ.
        let packed = std::mem::take(decoder.get_mut());
        *decoder = Lz4::new(packed);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use lz4_flex::frame::FrameEncoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    fn decompressed(packing: Packing, packed: Vec<u8>) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Unpacker::new(packing, packed)?.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn lz4(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = FrameEncoder::new(Vec::new());
        encoder.write_all(bytes).expect("memory");
        encoder.finish().expect("memory")
    }

    #[test]
    fn reads_consecutive_frames() {
        let (first, second) = (b"one ".repeat(50_000), b"two".repeat(7));
        let both = [&first[..], &second].concat();
        let zstd = |bytes: &[u8]| compress_to_vec(bytes, CompressionLevel::Fastest);
        let skipped = b"\x50\x2a\x4d\x18\x03\0\0\0abc".to_vec();
        let packed = [skipped.clone(), zstd(&first), skipped.clone(), zstd(&second), skipped].concat();
        assert_eq!(decompressed(Packing::Zstd, packed).expect("frames"), both);
        assert_eq!(decompressed(Packing::Lz4, [lz4(&first), lz4(&second)].concat()).expect("frames"), both);
        for packing in [Packing::Zstd, Packing::Lz4] {
            assert_eq!(decompressed(packing, Vec::new()).expect("no frame"), b"");
        }
    }

    #[test]
    fn rejects_invalid_and_truncated_frames() {
        let text = b"wind ".repeat(50_000);
        let zstd = compress_to_vec(&text[..], CompressionLevel::Fastest);
        for (packing, packed) in [(Packing::Zstd, zstd), (Packing::Lz4, lz4(&text))] {
            assert!(decompressed(packing, b"neither this nor that".to_vec()).is_err(), "{packing:?}");
            let found = decompressed(packing, packed[..packed.len() / 2].to_vec());
            assert!(found.is_err() || found.is_ok_and(|found| text.starts_with(&found)), "{packing:?}");
        }
    }
}
