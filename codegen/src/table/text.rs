//! Plain text that records the source location of each part.

use std::ops::Range;

use crate::source::Span;

/// The text of a cell or heading, without markup and with single spaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    plain: String,
    span: Span,
    /// Positions in the text, each with its source location. Between a position and the next one, the text is identical
    /// to the source.
    pieces: Vec<(usize, Span)>,
}

impl Text {
    /// The plain text.
    pub fn as_str(&self) -> &str {
        &self.plain
    }

    /// True if the text is empty.
    pub fn is_empty(&self) -> bool {
        self.plain.is_empty()
    }

    /// The source location, including markup.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The source location of a part of the text.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Span {
        if range.is_empty() {
            return self.span;
        }
        match (self.locate(range.start), self.locate(range.end - 1)) {
            (Some(first), Some(last)) => first.to(last),
            _ => self.span,
        }
    }

    /// The source location of the byte at `position`.
    fn locate(&self, position: usize) -> Option<Span> {
        let after = self.pieces.partition_point(|(start, _)| *start <= position);
        let (start, place) = self.pieces.get(after.checked_sub(1)?)?;
        let into = position - start;
        Some(place.part(into..into + 1))
    }
}

/// Collects a [`Text`] from pieces of the source.
pub(super) struct TextBuilder {
    page: Span,
    plain: String,
    pieces: Vec<(usize, Span)>,
    /// The source position after the last piece.
    next: usize,
    has_gap: bool,
}

impl TextBuilder {
    pub(super) fn new(page: Span) -> Self {
        Self { page, plain: String::new(), pieces: Vec::new(), next: 0, has_gap: false }
    }

    /// Adds `text`, which is at position `at` of the page.
    pub(super) fn push(&mut self, text: &str, at: usize) {
        let mut rest = text;
        while let Some(start) = rest.find(|c: char| !c.is_whitespace()) {
            self.has_gap |= start > 0;
            let word = &rest[start..];
            let len = word.find(char::is_whitespace).unwrap_or(word.len());
            self.push_word(&word[..len], at + (text.len() - word.len()));
            rest = &word[len..];
        }
        self.has_gap |= !rest.is_empty();
    }

    fn push_word(&mut self, word: &str, at: usize) {
        if self.has_gap && !self.plain.is_empty() {
            self.plain.push(' ');
            self.next += 1;
        }
        self.has_gap = false;
        if self.pieces.is_empty() || self.next != at {
            self.pieces.push((self.plain.len(), self.page.part(at..at)));
        }
        self.plain.push_str(word);
        self.next = at + word.len();
    }

    /// Adds `text`, and replaces `\|` with a pipe.
    pub(super) fn push_unescaped(&mut self, text: &str, at: usize) {
        let mut start = 0;
        for (backslash, _) in text.match_indices("\\|") {
            self.push(&text[start..backslash], at + start);
            start = backslash + 1;
        }
        self.push(&text[start..], at + start);
    }

    /// Adds white space.
    pub(super) fn gap(&mut self) {
        self.has_gap = true;
    }

    /// The text, located at `range` of the page.
    pub(super) fn finish(self, range: Range<usize>) -> Text {
        Text { plain: self.plain, span: self.page.part(range), pieces: self.pieces }
    }
}

/// Removes white space from both ends of `range`. If only white space remains, returns an empty range at its start.
pub(super) fn trim(text: &str, range: Range<usize>) -> Range<usize> {
    let inner = text.get(range.clone()).unwrap_or("");
    let start = range.start + (inner.len() - inner.trim_start().len());
    let len = inner.trim().len();
    if len == 0 { range.start..range.start } else { start..start + len }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_space_becomes_one_space_and_positions_stay_correct() {
        let source = "  ab \n\t c\\|d ";
        let page = Span { start: 100, end: 100 + 13 };
        let mut builder = TextBuilder::new(page);
        builder.push_unescaped(source, 0);
        let text = builder.finish(trim(source, 0..source.len()));
        assert_eq!(text.as_str(), "ab c|d");
        assert_eq!(text.span(), Span { start: 102, end: 112 });
        let at = |range: Range<usize>| {
            let span = text.part(range);
            &source[(span.start - 100) as usize..(span.end - 100) as usize]
        };
        assert_eq!((at(0..2), at(3..4), at(4..5), at(4..6)), ("ab", "c", "|", "|d"));
        assert_eq!(at(0..6), "ab \n\t c\\|d");
        assert_eq!(text.part(3..3), text.span(), "an empty part has the location of the whole text");
    }
}
