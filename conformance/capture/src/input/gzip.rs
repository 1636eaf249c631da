//! Decompresses gzip members (RFC 1952) as they are read. A file may contain several consecutive members.

use std::io::{self, BufRead, Read};

use flate2::bufread::GzDecoder;

use super::padding::skip_zeros;

/// The first bytes of a member.
pub(super) const MAGIC: [u8; 2] = [0x1f, 0x8b];

/// The maximum number of bytes to decompress at a time. If data is corrupt, the decoder loses the bytes of at most one
/// piece.
const PIECE: usize = 4_096;

/// Decompresses consecutive members. Zeros after a member are ignored, as by `gzip`. Other data and truncated members
/// are errors, and so are members whose checksum or length is wrong.
pub(super) struct Members<R> {
    /// `None` only while the next member starts.
    member: Option<GzDecoder<R>>,
}

impl<R: BufRead> Members<R> {
    pub(super) fn new(input: R) -> Self {
        Self { member: Some(GzDecoder::new(input)) }
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let end = out.len().min(PIECE);
        while let Some(member) = &mut self.member {
            let read = member.read(&mut out[..end])?;
            if read > 0 || out.is_empty() {
                return Ok(read);
            }
            if !skip_zeros(member.get_mut())? {
                break;
            }
            self.member = self.member.take().map(|member| GzDecoder::new(member.into_inner()));
        }
        Ok(0)
    }
}
