//! Whether bytes can be a record, told by lengths that have to agree.

use mcap::records::op;

use super::MAGIC;

/// Bytes before what a record holds: its opcode and its length.
pub(super) const HEAD: usize = 9;

/// The longest record that is held whole: a large image takes half of it.
pub(super) const MAX_RECORD: u64 = 64 << 20;

/// Bytes of a chunk before the name of its packing, and behind it.
const CHUNK_FIXED: (usize, usize) = (28, 8);

/// The longest name of a packing that is believed.
const MAX_PACKING: usize = 64;

/// Most bytes that a later version may add to a chunk behind its records.
const MAX_ADDED: u64 = 4_096;

/// Bytes of a message before its payload.
const MESSAGE_FIXED: u64 = 22;

/// Bytes of the footer.
const FOOTER: u64 = 20;

/// The opcode and the length of a record.
pub(super) fn head(ahead: &[u8]) -> Option<(u8, u64)> {
    let (opcode, rest) = ahead.split_first()?;
    Some((*opcode, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// Whether a record of a kind can have a length.
pub(super) fn can_be(opcode: u8, length: u64) -> bool {
    match opcode {
        0 => false,
        op::FOOTER => length == FOOTER,
        op::DATA_END => length == 4,
        op::MESSAGE => (MESSAGE_FIXED..=MAX_RECORD).contains(&length),
        // These are read in parts, or passed over.
        op::CHUNK | op::ATTACHMENT => length <= u64::MAX >> 1,
        _ => length <= MAX_RECORD,
    }
}

/// What the start of a chunk says.
#[derive(Debug)]
pub(super) struct ChunkHead {
    /// Bytes of its records, unpacked.
    pub(super) size: u64,
    /// Their checksum; 0 where it says none.
    pub(super) checksum: u32,
    /// How it is packed; nothing where it isn't.
    pub(super) packing: Vec<u8>,
    /// Bytes before its records.
    pub(super) length: usize,
    /// Bytes of its records as they stand there.
    pub(super) packed: u64,
    /// Bytes behind its records.
    pub(super) added: u64,
}

/// The most bytes that the start of a chunk takes.
pub(super) const MAX_CHUNK_HEAD: usize = CHUNK_FIXED.0 + 4 + MAX_PACKING + CHUNK_FIXED.1;

impl ChunkHead {
    /// Reads the start of a chunk of so many bytes; nothing where its lengths don't agree.
    pub(super) fn read(body: &[u8], length: u64) -> Option<Self> {
        let mut parts = Parts(body);
        parts.take(16)?;
        let size = parts.u64()?;
        let checksum = parts.u32()?;
        let packing = parts.u32().filter(|length| *length as usize <= MAX_PACKING)?;
        let packing = parts.take(packing as usize)?.to_vec();
        let packed = parts.u64()?;
        let head = body.len() - parts.0.len();
        let added = length.checked_sub(head as u64)?.checked_sub(packed)?;
        let is_whole = !packing.is_empty() || packed == size;
        (added <= MAX_ADDED && is_whole).then_some(Self {
            size,
            checksum,
            packing,
            length: head,
            packed,
            added,
        })
    }
}

/// Whether the start of an attachment agrees with its length: its data and a checksum follow.
pub(super) fn is_attachment(start: &[u8], length: u64) -> bool {
    let mut parts = Parts(start);
    let data =
        parts.take(16).and_then(|_| parts.text()).and_then(|()| parts.text()).and_then(|()| parts.u64());
    let head = (start.len() - parts.0.len()) as u64;
    data.and_then(|data| data.checked_add(head)?.checked_add(4)) == Some(length)
}

/// Whether the parts of a record agree with its length. More may follow them in later versions, unless
/// `is_exact`.
pub(super) fn has_its_parts(opcode: u8, body: &[u8], is_exact: bool) -> bool {
    let mut parts = Parts(body);
    let are_there = match opcode {
        op::HEADER => parts.text().and_then(|()| parts.text()),
        op::SCHEMA => {
            let names = parts.take(2).and_then(|_| parts.text()).and_then(|()| parts.text());
            names.and_then(|()| parts.text())
        }
        op::CHANNEL => {
            let names = parts.take(4).and_then(|_| parts.text()).and_then(|()| parts.text());
            names.and_then(|()| parts.texts())
        }
        op::MESSAGE_INDEX => parts.take(2).and_then(|_| parts.u32()).and_then(|length| {
            let entries = parts.take(length as usize)?;
            entries.len().is_multiple_of(16).then_some(())
        }),
        op::METADATA => parts.text().and_then(|()| parts.texts()),
        _ => return true,
    };
    are_there.is_some() && (parts.0.is_empty() || !is_exact)
}

/// Whether a record surely begins here, as far as bytes can say so. `is_declared` says which channels there are.
///
/// There are kinds of which this can't be said; those are no places to go on from.
pub(super) fn is_sound(ahead: &[u8], is_declared: impl Fn(u16) -> bool) -> bool {
    let Some((opcode, length)) = head(ahead) else { return false };
    let is_of_kind = matches!(
        opcode,
        op::FOOTER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK | op::MESSAGE_INDEX | op::DATA_END
    );
    if !is_of_kind || !can_be(opcode, length) {
        return false;
    }
    let body = &ahead[HEAD..];
    if opcode == op::CHUNK {
        return ChunkHead::read(body, length).is_some_and(|head| head.added == 0);
    }
    let Some((body, rest)) = usize::try_from(length).ok().and_then(|length| body.split_at_checked(length))
    else {
        return false;
    };
    let channel = || body.first_chunk().map(|id| u16::from_le_bytes(*id));
    match opcode {
        op::FOOTER => rest.starts_with(&MAGIC),
        op::MESSAGE => channel().is_some_and(is_declared) && can_follow(rest),
        op::DATA_END => can_follow(rest),
        _ => has_its_parts(opcode, body, true),
    }
}

/// Whether a record can begin here; nothing speaks against the end of what is known.
pub(super) fn can_follow(ahead: &[u8]) -> bool {
    match head(ahead) {
        Some((opcode, length)) => {
            // Kinds from 0x80 on are for everyone's own use.
            (opcode <= op::DATA_END || opcode >= 0x80) && can_be(opcode, length) && length >> 40 == 0
        }
        None => ahead.is_empty(),
    }
}

/// Takes a record to pieces.
struct Parts<'b>(&'b [u8]);

impl<'b> Parts<'b> {
    fn take(&mut self, length: usize) -> Option<&'b [u8]> {
        let (part, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(part)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(*self.take(8)?.first_chunk()?))
    }

    /// A text behind its length.
    fn text(&mut self) -> Option<()> {
        let length = self.u32()?;
        self.take(length as usize).map(|_| ())
    }

    /// Pairs of texts behind the length of them all.
    fn texts(&mut self) -> Option<()> {
        let length = self.u32()?;
        let mut pairs = Parts(self.take(length as usize)?);
        while !pairs.0.is_empty() {
            pairs.text()?;
            pairs.text()?;
        }
        Some(())
    }
}
