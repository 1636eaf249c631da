//! Values that are unlike their neighbours: swapped fields, wrong offsets and a wrong order of bytes
//! all show in them.

use uavspec_runtime::Scalar;

/// Most elements of a sequence; a sequence within a sequence has one less for each level, so that
/// nesting doesn't multiply them.
const SEQUENCE: u32 = 3;

/// Numbers bytes through from 1 to 255 and again from 1.
#[derive(Debug, Default)]
pub(super) struct Typical {
    last: u8,
    depth: u32,
    strings: u32,
}

impl Typical {
    fn byte(&mut self) -> u8 {
        self.last = self.last % u8::MAX + 1;
        self.last
    }

    /// As many bytes as `scalar` has, and zeros up to eight.
    pub(super) fn bytes(&mut self, scalar: Scalar) -> [u8; 8] {
        let mut bytes = [0; 8];
        for byte in bytes.iter_mut().take(scalar.size()) {
            *byte = self.byte();
        }
        bytes
    }

    /// True and false by turns.
    pub(super) fn boolean(&mut self) -> bool {
        self.byte() % 2 == 1
    }

    /// Text that leaves room for a NUL.
    pub(super) fn text(&mut self, room: u32) -> String {
        let first = self.byte();
        format!("\"{}\"", letters(first, room.saturating_sub(1).max(1).min(room)))
    }

    /// Another string each time.
    pub(super) fn string(&mut self, bound: Option<u32>) -> String {
        self.strings += 1;
        let text: String = format!("{}é", self.strings);
        let room = bound.map_or(usize::MAX, |bound| bound as usize);
        format!("\"{}\"", text.chars().take(room).collect::<String>())
    }

    /// The length of a sequence.
    pub(super) fn sequence(&self) -> u32 {
        SEQUENCE.saturating_sub(self.depth)
    }

    pub(super) fn enter(&mut self) {
        self.depth += 1;
    }

    pub(super) fn leave(&mut self) {
        self.depth -= 1;
    }
}

/// Different letters, one after another, from the letter of the alphabet with the number `first` on.
pub(super) fn letters(first: u8, length: u32) -> String {
    ('a'..='z').cycle().skip(first.into()).take(length as usize).collect()
}
