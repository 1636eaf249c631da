//! Values whose adjacent bytes differ. Such values reveal swapped fields, wrong offsets and a wrong byte order.

use uavspec_runtime::Scalar;

/// Maximum length of a sequence. The length decreases by one per nesting level to limit the total number of elements.
const SEQUENCE: u32 = 3;

/// A source of values. The bytes count from 1 to 255, then start again at 1.
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

    /// The next bytes for a scalar, padded with zeros to eight bytes.
    pub(super) fn bytes(&mut self, scalar: Scalar) -> [u8; 8] {
        let mut bytes = [0; 8];
        for byte in bytes.iter_mut().take(scalar.size()) {
            *byte = self.byte();
        }
        bytes
    }

    /// Alternates between true and false.
    pub(super) fn boolean(&mut self) -> bool {
        self.byte() % 2 == 1
    }

    /// The next text. If possible, the text leaves room for a NUL.
    pub(super) fn text(&mut self, room: u32) -> String {
        let first = self.byte();
        format!("\"{}\"", letters(first, room.saturating_sub(1).max(1).min(room)))
    }

    /// The next string, different from the previous one. If the bytes of a string with a multibyte character exceed the
    /// bound, the string is ASCII, because implementations differ in how they count multibyte characters.
    pub(super) fn string(&mut self, bound: Option<u32>) -> String {
        self.strings += 1;
        let number = self.strings.to_string();
        let text = format!("{number}é");
        let room = bound.map_or(usize::MAX, |bound| bound as usize);
        if text.len() <= room {
            return format!("\"{text}\"");
        }
        format!("\"{}\"", number.get(..room).unwrap_or(&number))
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

/// Consecutive letters of the alphabet, starting at index `first`.
pub(super) fn letters(first: u8, length: u32) -> String {
    ('a'..='z').cycle().skip(first.into()).take(length as usize).collect()
}
