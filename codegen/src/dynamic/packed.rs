//! Messages of fixed size whose CDR starts with them: each byte of both forms has its place, so going from
//! one to the other is a list of copies, worked out once.

use uavspec_runtime::cdr::{ByteOrder, HEADER, is_padding};

use super::bytes::{copy, copy_short, make_bools, part};
use super::step::Width;

/// The copies of a type.
#[derive(Debug)]
pub(super) struct Packed {
    /// Size of the CDR form without its header, in bytes.
    size: usize,
    /// What lies side by side in both forms, whatever it is.
    copies: Box<[Move]>,
    /// The same in parts of one width each, whose bytes can be swapped.
    swaps: Box<[Move]>,
    /// Where `bool`s are in memory, and in CDR.
    bools: Box<[Move]>,
    /// Padding in memory: starts and sizes.
    gaps: Box<[(usize, usize)]>,
}

/// Bytes that are in both forms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Move {
    pub(super) memory: usize,
    pub(super) cdr: usize,
    pub(super) size: usize,
    pub(super) width: Width,
    pub(super) is_bool: bool,
}

impl Packed {
    /// The copies of a type, given in the order of CDR, where it takes `size` bytes; in memory it takes `padded`.
    pub(super) fn new(moves: Vec<Move>, size: usize, padded: usize) -> Self {
        let bools = moves.iter().copied().filter(|part| part.is_bool).collect();
        let mut in_memory = moves.clone();
        in_memory.sort_by_key(|part| part.memory);
        Self { size, bools, gaps: gaps(&in_memory, padded), copies: merged(&moves), swaps: moves.into() }
    }

    /// Reads a payload; nothing where it isn't as long as it should be.
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

    /// The payload of a message.
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

    /// The memory form, with padding of zeros and `bool`s of 0 and 1.
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

/// Joins what lies side by side in both forms.
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
