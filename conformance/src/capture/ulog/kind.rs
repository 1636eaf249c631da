//! The kinds of messages, by the letter in their header.

/// Bytes of a header: the size of the payload as `uint16`, and the kind.
pub(super) const HEADER: usize = 3;

/// Most bytes of a message with its header.
pub(super) const LARGEST: usize = HEADER + u16::MAX as usize;

/// The magic of a sync message, which is all of its payload.
pub(super) const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// Each known kind with the least size of its payload, and the most that is usual.
///
/// Least: a format is a name of one character and a colon, the entries have the length of a key and `t k`,
/// and the others a fixed part and a text that may be empty. A message of less can't be read.
///
/// Usual: what PX4 writes, with room to spare. A message of more is believed after a closer look. Flag bits
/// are usual only at the start, where nothing is asked.
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

/// [`KINDS`] by kind. Where the kind is unknown, the least is more than any size.
static SIZES: [(u32, u16); 256] = {
    let mut table = [(u32::MAX, 0); 256];
    let mut row = 0;
    while row < KINDS.len() {
        let (kind, least, usual) = KINDS[row];
        table[kind as usize] = (least as u32, usual);
        row += 1;
    }
    table
};

/// The head of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) size: u16,
    pub(super) kind: u8,
}

impl Header {
    /// The header that `bytes` start with.
    #[inline]
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        let [low, high, kind] = *bytes.first_chunk()?;
        Some(Self { size: u16::from_le_bytes([low, high]), kind })
    }

    /// Bytes of the whole message.
    #[inline]
    pub(super) fn total(self) -> usize {
        HEADER + usize::from(self.size)
    }

    /// Whether the kind is known and the size large enough for it.
    #[inline]
    pub(super) fn is_believable(self) -> bool {
        u32::from(self.size) >= SIZES[usize::from(self.kind)].0
    }

    /// Whether messages of this kind have such sizes in most logs.
    pub(super) fn is_usual(self) -> bool {
        self.is_believable() && self.size <= SIZES[usize::from(self.kind)].1
    }

    /// Whether the kind is known, whatever the size.
    pub(super) fn is_known(self) -> bool {
        SIZES[usize::from(self.kind)].0 != u32::MAX
    }
}
