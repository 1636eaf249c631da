//! A chunk and its records.

use std::io::{self, Read};

use mcap::records::op;

use super::sound::{self, HEAD, can_be, has_parts, is_private};
use super::unpack::{Packing, Unpacker};
use super::window::Window;
use crate::limits::MAX_RECORD;

/// A chunk that is being read.
pub(super) struct Chunk {
    pub(super) offset: u64,
    pub(super) size: u64,
    pub(super) checksum: u32,
    pub(super) packing: Option<Packing>,
    /// The number of bytes after the records.
    pub(super) added: u64,
    pub(super) records: Records,
}

/// The location of a chunk's records.
pub(super) enum Records {
    /// Uncompressed, starting at this file offset.
    Plain(u64),
    /// Compressed. The flag is true if the file ended within the records.
    Packed(Box<Window<Unpacker>>, bool),
}

/// The next item of a chunk.
pub(super) enum Next {
    Record {
        opcode: u8,
        length: usize,
    },
    /// A record that isn't allowed in a chunk, or whose kind is unknown.
    Passed {
        opcode: u8,
    },
    TooLong {
        opcode: u8,
        length: u64,
    },
    Corrupt,
    End,
}

/// Reads the next record of a chunk. `left` is the number of remaining bytes.
pub(super) fn next_record<R: Read>(window: &mut Window<R>, left: u64) -> io::Result<Next> {
    if left == 0 {
        return Ok(Next::End);
    }
    window.require(HEAD)?;
    let Some((opcode, length)) = sound::head(window.ahead()) else { return Ok(Next::Corrupt) };
    let is_within = length.checked_add(HEAD as u64).is_some_and(|whole| whole <= left);
    if opcode == 0 || !is_within {
        return Ok(Next::Corrupt);
    }
    let is_wanted = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) || is_private(opcode);
    if !is_wanted || length > MAX_RECORD {
        let whole = HEAD as u64 + length;
        let is_there = window.skip(whole)? == whole;
        return Ok(match (is_there, is_wanted) {
            (false, _) => Next::Corrupt,
            (true, true) => Next::TooLong { opcode, length },
            (true, false) => Next::Passed { opcode },
        });
    }
    // The length is within the limit, so it fits into a `usize`.
    let length = usize::try_from(length).unwrap_or(usize::MAX - HEAD);
    window.require(HEAD + length)?;
    let Some(body) = window.ahead().get(HEAD..HEAD + length) else { return Ok(Next::Corrupt) };
    if !can_be(opcode, length as u64) || !has_parts(opcode, body, false) {
        return Ok(Next::Corrupt);
    }
    window.advance(HEAD + length);
    Ok(Next::Record { opcode, length })
}
