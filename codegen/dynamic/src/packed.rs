//! Copy operations for fixed-size messages. Each byte has a fixed offset in memory and in CDR, so the list of copy
//! operations is computed only once.

use uavspec_runtime::cdr::{ByteOrder, HEADER, is_padding};

use super::bytes::{copy, copy_short, make_bools, part};
use super::step::Width;

/// The copy operations for a type.
#[derive(Debug)]
pub(super) struct Packed {
    /// Size of the CDR form without its header, in bytes.
    size: usize,
    /// Ranges that are contiguous in both forms.
    copies: Box<[Move]>,
    /// The ranges in `copies`, split by number width to allow byte swapping.
    swaps: Box<[Move]>,
    /// The ranges of `bool`s in both forms.
    bools: Box<[Move]>,
    /// Offsets and sizes of the padding in memory.
    gaps: Box<[(usize, usize)]>,
}

/// A byte range that exists in both forms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Move {
    pub(super) memory: usize,
    pub(super) cdr: usize,
    pub(super) size: usize,
    pub(super) width: Width,
    pub(super) is_bool: bool,
}

impl Packed {
    /// Creates the copy operations for a type from `moves` in CDR order. `size` is the CDR size of the type, and
    /// `padded` is its size in memory.
    pub(super) fn new(moves: Vec<Move>, size: usize, padded: usize) -> Self {
        let bools = moves.iter().copied().filter(|part| part.is_bool).collect();
        let mut in_memory = moves.clone();
        in_memory.sort_by_key(|part| part.memory);
        Self { size, bools, gaps: gaps(&in_memory, padded), copies: merged(&moves), swaps: moves.into() }
    }

    /// Reads a payload. Returns `None` if its length is wrong.
    pub(super) fn read(&self, payload: &[u8], order: ByteOrder, padded: usize) -> Option<Vec<u8>> {
        let end = HEADER + self.size;
        let body = payload.get(HEADER..end)?;
        if payload.len() > end && !is_padding(end, payload.len() - end) {
            return None;
        }
        let mut memory = vec![0; padded];
        for part in self.moves(order) {
            let from = body.get(part.cdr..part.cdr + part.size)?;
            part.copy(order, from, memory.get_mut(part.memory..part.memory + part.size)?);
        }
        Some(memory)
    }

    /// Encodes a message as a CDR payload.
    pub(super) fn write(&self, memory: &[u8], order: ByteOrder) -> Option<Vec<u8>> {
        let mut payload = vec![0; HEADER + self.size];
        let (header, body) = payload.split_first_chunk_mut()?;
        *header = order.header();
        for part in self.moves(order) {
            let from = memory.get(part.memory..part.memory + part.size)?;
            part.copy(order, from, body.get_mut(part.cdr..part.cdr + part.size)?);
        }
        for part in &self.bools {
            make_bools(body.get_mut(part.cdr..part.cdr + part.size)?);
        }
        Some(payload)
    }

    /// Copies the memory form, with zeroed padding and `bool`s normalized to 0 and 1.
    pub(super) fn clean(&self, memory: &[u8], padded: usize) -> Option<Vec<u8>> {
        let mut payload = Vec::with_capacity(padded);
        payload.extend_from_slice(part(memory, 0, memory.len().min(padded)));
        payload.resize(padded, 0);
        for (start, size) in &self.gaps {
            payload.get_mut(*start..start + size)?.fill(0);
        }
        for part in &self.bools {
            make_bools(payload.get_mut(part.memory..part.memory + part.size)?);
        }
        Some(payload)
    }

    #[inline]
    fn moves(&self, order: ByteOrder) -> &[Move] {
        match order {
            ByteOrder::LittleEndian => &self.copies,
            ByteOrder::BigEndian => &self.swaps,
        }
    }
}

impl Move {
    #[inline]
    fn copy(self, order: ByteOrder, from: &[u8], to: &mut [u8]) {
        match order {
            ByteOrder::LittleEndian => copy_short(from, to),
            ByteOrder::BigEndian => copy::<true>(from, to, self.width),
        }
    }
}

/// Merges moves that are adjacent in both forms.
fn merged(moves: &[Move]) -> Box<[Move]> {
    let mut merged: Vec<Move> = Vec::new();
    for next in moves {
        match merged.last_mut() {
            Some(last) if last.memory + last.size == next.memory && last.cdr + last.size == next.cdr => {
                last.size += next.size;
            }
            _ => merged.push(*next),
        }
    }
    merged.into()
}

fn gaps(in_memory: &[Move], padded: usize) -> Box<[(usize, usize)]> {
    let starts = in_memory.iter().map(|part| part.memory).chain([padded]);
    let ends = [0].into_iter().chain(in_memory.iter().map(|part| part.memory + part.size));
    ends.zip(starts).filter(|(end, start)| start > end).map(|(end, start)| (end, start - end)).collect()
}
