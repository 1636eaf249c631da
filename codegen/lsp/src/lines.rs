//! Positions of the protocol: a line, and a column in code units.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use lsp_types::{self as lsp, Position, PositionEncodingKind};
use uavspec_schema::render::floor_char_boundary;

/// The code units in which columns are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Encoding {
    Utf8,
    /// The encoding of clients that offer no other encoding.
    #[default]
    Utf16,
}

impl Encoding {
    /// Chooses one of the encodings that a client offers.
    pub(super) fn choose(offered: &[PositionEncodingKind]) -> Self {
        if offered.contains(&PositionEncodingKind::UTF8) { Self::Utf8 } else { Self::Utf16 }
    }

    /// The name in the protocol.
    pub(super) fn kind(self) -> PositionEncodingKind {
        match self {
            Self::Utf8 => PositionEncodingKind::UTF8,
            Self::Utf16 => PositionEncodingKind::UTF16,
        }
    }

    /// The number of code units of a text.
    pub(super) fn len(self, text: &str) -> u32 {
        let len = match self {
            Self::Utf8 => text.len(),
            Self::Utf16 => text.chars().map(char::len_utf16).sum(),
        };
        u32::try_from(len).unwrap_or(u32::MAX)
    }

    /// The byte offset of a column, limited to the end of the line. For a column within a character, returns the start
    /// of the character.
    fn offset(self, line: &str, column: u32) -> usize {
        let mut units = 0;
        for (at, character) in line.char_indices() {
            units += match self {
                Self::Utf8 => character.len_utf8(),
                Self::Utf16 => character.len_utf16(),
            };
            if units > column as usize {
                return at;
            }
        }
        line.len()
    }
}

/// The number of UTF-16 code units of characters, the last of which may be incomplete. All code units of a character
/// count at its first byte.
fn utf16_len(bytes: &[u8]) -> u32 {
    let units = |byte: &u8| -> u32 {
        match *byte {
            0x80..=0xbf => 0,
            0xf0..=0xff => 2,
            _ => 1,
        }
    };
    bytes.iter().map(units).sum()
}

/// The number of bytes in a block of a text.
const BLOCK: usize = 256;

/// A text and the starts of its lines.
#[derive(Debug)]
pub(super) struct Lines<'t> {
    text: &'t str,
    index: Arc<Index>,
    encoding: Encoding,
}

/// The positions of the lines in a text.
#[derive(Debug)]
pub(super) struct Index {
    starts: Vec<usize>,
    /// The number of UTF-16 code units before each block of the text, counted lazily. These counts avoid quadratic time
    /// for many positions in one line.
    counts: OnceLock<Vec<u32>>,
}

impl Index {
    pub(super) fn new(text: &str) -> Self {
        let starts =
            std::iter::once(0).chain(text.match_indices('\n').map(|(newline, _)| newline + 1)).collect();
        Self { starts, counts: OnceLock::new() }
    }
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t str, encoding: Encoding) -> Self {
        Self::with_index(text, Arc::new(Index::new(text)), encoding)
    }

    /// Creates the lines of a text whose index is known.
    pub(super) fn with_index(text: &'t str, index: Arc<Index>, encoding: Encoding) -> Self {
        Self { text, index, encoding }
    }

    /// The text.
    pub(super) fn text(&self) -> &'t str {
        self.text
    }

    /// The code units in which columns are counted.
    pub(super) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The number of lines.
    pub(super) fn count(&self) -> usize {
        self.index.starts.len()
    }

    /// The byte offset of the start of a line, or the end of the text if there is no such line.
    pub(super) fn start(&self, line: usize) -> usize {
        self.index.starts.get(line).copied().unwrap_or(self.text.len())
    }

    /// The text of a line, without its line break.
    pub(super) fn line(&self, line: usize) -> &'t str {
        self.text[self.start(line)..self.start(line + 1)].trim_end_matches(['\n', '\r'])
    }

    /// The number of the line that contains a byte offset, from 0.
    pub(super) fn line_of(&self, offset: usize) -> usize {
        self.index.starts.partition_point(|start| *start <= offset) - 1
    }

    /// The position of a byte offset.
    pub(super) fn position(&self, offset: usize) -> Position {
        let offset = floor_char_boundary(self.text, offset);
        let line = self.line_of(offset);
        let character = self.units(offset).saturating_sub(self.units(self.index.starts[line]));
        Position { line: u32::try_from(line).unwrap_or(u32::MAX), character }
    }

    /// The number of code units before a byte offset.
    fn units(&self, offset: usize) -> u32 {
        let bytes = self.text.as_bytes();
        if self.encoding == Encoding::Utf8 {
            return u32::try_from(offset).unwrap_or(u32::MAX);
        }
        let counts = self.index.counts.get_or_init(|| {
            let mut counts = vec![0_u32];
            let mut sum = 0_u32;
            for block in bytes.chunks(BLOCK) {
                sum = sum.saturating_add(utf16_len(block));
                counts.push(sum);
            }
            counts
        });
        let block = offset / BLOCK;
        counts.get(block).map_or(0, |count| count.saturating_add(utf16_len(&bytes[block * BLOCK..offset])))
    }

    /// The range of byte offsets.
    pub(super) fn range(&self, range: Range<usize>) -> lsp::Range {
        lsp::Range { start: self.position(range.start), end: self.position(range.end) }
    }

    /// The byte offset of a position. A position outside the text is moved to the nearest end.
    pub(super) fn offset(&self, position: Position) -> usize {
        let line = position.line as usize;
        self.start(line) + self.encoding.offset(self.line(line), position.character)
    }

    /// The byte offsets of a range, in ascending order.
    pub(super) fn offsets(&self, range: lsp::Range) -> Range<usize> {
        let (start, end) = (self.offset(range.start), self.offset(range.end));
        start..end.max(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: u32, character: u32) -> Position {
        Position { line, character }
    }

    #[test]
    fn columns_count_code_units() {
        let text = "aé𝄞b\r\n\nxy";
        for (encoding, b) in [(Encoding::Utf8, 7), (Encoding::Utf16, 4)] {
            let lines = Lines::new(text, encoding);
            assert_eq!(lines.position(7), at(0, b), "{encoding:?}");
            assert_eq!(lines.offset(at(0, b)), 7, "{encoding:?}");
            assert_eq!(lines.offset(at(0, 3)), 3, "{encoding:?}: within a character");
            assert_eq!(lines.position(4), at(0, if b == 7 { 3 } else { 2 }), "within a character");
        }
    }

    #[test]
    fn columns_of_a_long_line_are_counted_in_blocks() {
        let text = "\n".to_owned() + &"aé𝄞".repeat(2 * BLOCK);
        for encoding in [Encoding::Utf8, Encoding::Utf16] {
            let lines = Lines::new(&text, encoding);
            for (offset, _) in text.char_indices().skip(1) {
                assert_eq!(lines.position(offset), at(1, encoding.len(&text[1..offset])), "{encoding:?}");
            }
            assert_eq!(lines.position(text.len()), at(1, encoding.len(&text[1..])));
        }
    }

    #[test]
    fn positions_outside_the_text_are_moved_to_its_end() {
        let lines = Lines::new("ab\r\nc", Encoding::Utf16);
        assert_eq!(lines.offset(at(0, 99)), 2, "before the line break");
        assert_eq!(lines.offset(at(9, 9)), 5);
        assert_eq!(lines.position(99), at(1, 1));
        let reversed = lsp::Range { start: at(1, 0), end: at(0, 0) };
        assert_eq!(lines.offsets(reversed), 4..4);
        assert_eq!((lines.count(), lines.line(0), lines.line(1), lines.line(7)), (2, "ab", "c", ""));
    }
}
