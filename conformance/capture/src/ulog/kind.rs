//! The kinds of messages, identified by the letter in the header.

/// The size of a header: the size of the payload as `uint16`, and the kind.
pub(super) const HEADER: usize = 3;

/// The maximum size of a message with its header, in bytes.
pub(super) const LARGEST: usize = HEADER + u16::MAX as usize;

/// The magic, which is the whole payload of a sync message.
pub(super) const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// The known kinds, each with the minimum and the largest usual size of its payload.
///
/// Minimum: a format consists of at least a one-character name and a colon. An information or parameter message
/// consists of at least a key length and the key `t k`. Other messages consist of a fixed part and a text, which may be
/// empty. Shorter messages are invalid.
///
/// Usual: sizes that PX4 writes, with a margin. Larger messages are accepted after closer inspection. Flag bits are
/// expected only at the start of a log, where sizes aren't compared with the usual size.
const KINDS: [(u8, u16, u16); 13] = [
    (b'B', 40, 0),
    (b'F', 2, 8_192),
    (b'I', 4, 1_024),
    (b'M', 5, 1_024),
    (b'P', 4, 255),
    (b'Q', 5, 255),
    (b'A', 4, 255),
    (b'R', 2, 2),
    (b'D', 2, u16::MAX),
    (b'L', 9, 512),
    (b'C', 11, 512),
    (b'S', 8, 8),
    (b'O', 2, 2),
];

/// The sizes of [`KINDS`], indexed by kind. For unknown kinds, the minimum is larger than any payload.
static SIZES: [(u32, u16); 256] = {
    let mut table = [(u32::MAX, 0); 256];
    let mut row = 0;
    while row < KINDS.len() {
        let (kind, min, usual) = KINDS[row];
        table[kind as usize] = (min as u32, usual);
        row += 1;
    }
    table
};

/// The header of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) size: u16,
    pub(super) kind: u8,
}

impl Header {
    /// Parses the header at the start of `bytes`.
    #[inline]
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let [low, high, kind] = *bytes.first_chunk()?;
        Some(Self { size: u16::from_le_bytes([low, high]), kind })
    }

    /// The size of the whole message, in bytes.
    #[inline]
    pub(super) fn total(self) -> usize {
        HEADER + usize::from(self.size)
    }

    /// True if the kind is known and the payload has at least the minimum size.
    #[inline]
    pub(super) fn is_plausible(self) -> bool {
        u32::from(self.size) >= SIZES[usize::from(self.kind)].0
    }

    /// True if this size is usual for the kind.
    pub(super) fn is_usual(self) -> bool {
        self.is_plausible() && self.size <= SIZES[usize::from(self.kind)].1
    }

    /// True if the kind is known, regardless of the size.
    pub(super) fn is_known(self) -> bool {
        SIZES[usize::from(self.kind)].0 != u32::MAX
    }
}
