//! The kinds of messages, by the letter in their header.

/// Bytes of a header: the size of the payload as `uint16`, and the kind.
pub(super) const HEADER: usize = 3;

/// Most bytes of a message with its header.
pub(super) const LARGEST: usize = HEADER + u16::MAX as usize;

/// The magic of a sync message, which is all of its payload.
pub(super) const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// Least size of the payload of each known kind. Format: a name of one character and a colon. Information
/// and parameters: the length of the key, and `t k`. Most have a fixed part and a text that may be empty.
const LEAST: [(u8, u32); 13] = [
    (b'B', 40),
    (b'F', 2),
    (b'I', 4),
    (b'M', 5),
    (b'P', 4),
    (b'Q', 5),
    (b'A', 4),
    (b'R', 2),
    (b'D', 2),
    (b'L', 9),
    (b'C', 11),
    (b'S', 8),
    (b'O', 2),
];

/// [`LEAST`] by kind; more than any size where the kind is unknown.
static LEAST_BY_KIND: [u32; 256] = {
    let mut table = [u32::MAX; 256];
    let mut row = 0;
    while row < LEAST.len() {
        table[LEAST[row].0 as usize] = LEAST[row].1;
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
        u32::from(self.size) >= LEAST_BY_KIND[usize::from(self.kind)]
    }

    /// Whether the kind is known, whatever the size.
    pub(super) fn is_known(self) -> bool {
        LEAST_BY_KIND[usize::from(self.kind)] != u32::MAX
    }
}
