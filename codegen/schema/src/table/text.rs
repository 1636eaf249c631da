//! Plain text that records the source location of each part.

use std::ops::Range;

use crate::source::Span;

/// The text of a cell or heading, without markup and with single spaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    plain: String,
    span: Span,
    pieces: Vec<Piece>,
}

/// A part of a text, up to the next piece.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    /// The position in the text.
    start: usize,
    source: Source,
}

/// The source of a piece.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    /// The source text that starts at this location is identical to the piece.
    Same(Span),
    /// The source at this location has another form, such as `&amp;` for `&`.
    Other(Span),
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

    /// The source location of a part of the text, without the spaces at its ends. A space may be any white space in the
    /// source.
    #[must_use]
    pub fn part(&self, range: Range<usize>) -> Span {
        let range = trim(&self.plain, range);
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
        let after = self.pieces.partition_point(|piece| piece.start <= position);
        let piece = self.pieces.get(after.checked_sub(1)?)?;
        let into = position - piece.start;
        Some(match piece.source {
            Source::Same(place) => place.part(into..into + 1),
            Source::Other(place) => place,
        })
    }
}

/// Collects a [`Text`] from pieces of the source.
pub(super) struct TextBuilder {
    page: Span,
    plain: String,
    pieces: Vec<Piece>,
    /// The source position after the last piece, if the piece is identical to the source.
    next: Option<usize>,
    has_gap: bool,
}

impl TextBuilder {
    pub(super) fn new(page: Span) -> Self {
        Self { page, plain: String::new(), pieces: Vec::new(), next: None, has_gap: false }
    }

    /// Adds `text`, which is at position `at` of the page.
    pub(super) fn push(&mut self, text: &str, at: usize) {
        self.push_words(text, |builder, word, start| builder.push_word(word, at + start));
    }

    /// Adds `text`, which was read from `range` of `page`. The page may have markup, escapes, entities or line breaks
    /// in this range.
    pub(super) fn push_read(&mut self, text: &str, page: &str, range: Range<usize>) {
        if let Some(start) = page[range.clone()].find(text) {
            return self.push(text, range.start + start);
        }
        let mut rest = range.clone();
        self.push_words(text, |builder, word, _| match page[rest.clone()].find(word) {
            Some(start) => {
                builder.push_word(word, rest.start + start);
                rest.start += start + word.len();
            }
            None => builder.push_other(word, range.clone()),
        });
    }

    /// Calls `push` for each word of `text` and its position in it. White space between words becomes a gap.
    fn push_words(&mut self, text: &str, mut push: impl FnMut(&mut Self, &str, usize)) {
        let mut rest = text;
        while let Some(start) = rest.find(|c: char| !c.is_whitespace()) {
            self.has_gap |= start > 0;
            let word = &rest[start..];
            let len = word.find(char::is_whitespace).unwrap_or(word.len());
            push(self, &word[..len], text.len() - word.len());
            rest = &word[len..];
        }
        self.has_gap |= !rest.is_empty();
    }

    /// Adds a word that is at position `at` of the page.
    fn push_word(&mut self, word: &str, at: usize) {
        self.fill_gap();
        if self.next != Some(at) {
            self.push_piece(Source::Same(self.page.part(at..at)));
        }
        self.plain.push_str(word);
        self.next = Some(at + word.len());
    }

    /// Adds a word that has another form in the source.
    fn push_other(&mut self, word: &str, range: Range<usize>) {
        self.fill_gap();
        self.push_piece(Source::Other(self.page.part(range)));
        self.plain.push_str(word);
        self.next = None;
    }

    fn push_piece(&mut self, source: Source) {
        self.pieces.push(Piece { start: self.plain.len(), source });
    }

    /// Adds the space for a gap before the next word.
    fn fill_gap(&mut self) {
        if std::mem::take(&mut self.has_gap) && !self.plain.is_empty() {
            self.plain.push(' ');
            self.next = self.next.map(|next| next + 1);
        }
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

    #[test]
    fn text_in_another_form_has_the_location_of_its_whole_source() {
        let source = "`a\r\n\u{2028}bé` &nGt;é";
        let place = |part: &str| source.find(part).expect("is a part")..source.len();
        let mut builder = TextBuilder::new(Span { start: 0, end: 99 });
        builder.push_read("a bé", source, 0..place(" ").start);
        builder.gap();
        builder.push_read("\u{226B}\u{20D2}", source, place("&").start..place(";").start + 1);
        builder.push_read("é", source, place(";").start + 1..source.len());
        let text = builder.finish(0..source.len());
        assert_eq!(text.as_str(), "a bé \u{226B}\u{20D2}é");
        let at = |part: &str| {
            let start = text.as_str().find(part).expect("is a part");
            let span = text.part(start..start + part.len());
            &source[span.start as usize..span.end as usize]
        };
        assert_eq!((at("a"), at("bé"), at("\u{226B}")), ("a", "bé", "&nGt;"));
        assert_eq!((at("\u{20D2}é"), at("a "), at(" ")), ("&nGt;é", "a", source));
    }
}
