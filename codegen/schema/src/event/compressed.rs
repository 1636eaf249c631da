//! Event metadata as PX4 stores it: JSON, compressed with xz.

use std::io::{self, ErrorKind, Read};

use lzma_rust2::XzReader;

use crate::limits::{MAX_EVENTS_LEN, MAX_XZ_MEMORY};

/// The first bytes of every xz file.
const MAGIC: [u8; 6] = [0xFD, b'7', b'z', b'X', b'Z', 0];

/// True if bytes are compressed with xz.
pub fn is_compressed(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Decompresses event metadata, and verifies its checksum. Fails if the bytes are corrupt, or if the result is longer
/// than 1 MiB.
pub fn decompress(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut reader = XzReader::new_mem_limit(bytes, false, MAX_XZ_MEMORY);
    let mut text = Vec::new();
    let first = reader.by_ref().take(MAX_EVENTS_LEN as u64).read_to_end(&mut text);
    // Read to the end of the stream, which contains the checksum.
    let rest = first.and_then(|_| reader.read(&mut [0])).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => io::Error::new(error.kind(), "truncated xz data"),
        kind => io::Error::new(kind, format!("corrupt xz data: {error}")),
    })?;
    if rest > 0 {
        return Err(io::Error::other(format!("more than {MAX_EVENTS_LEN} bytes after decompression")));
    }
    Ok(text)
}
