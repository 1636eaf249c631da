//! Source text with file paths, and locations in the text. Independent of the file system.
//!
//! ```
//! use uavspec_schema::source::{Position, SourceMap};
//!
//! let mut sources = SourceMap::default();
//! let id = sources.add("Wind.msg", "float32 speed\nfloat32 gust\n".into()).unwrap();
//! let gust = sources.span(id).part(22..26);
//! assert_eq!(sources.slice(gust), "gust");
//! assert_eq!(sources.position(gust), Position { line: 2, column: 9 });
//! ```

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::OnceLock;

use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::MAX_SOURCE_LEN;
pub use crate::span::Span;
use crate::span::offset;

/// The index of a source in a [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(u32);

/// A line and a column, both starting at 1. Columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
}

/// A span with its source and its first line.
#[derive(Debug)]
pub(crate) struct Located<'s> {
    /// The path of the source.
    pub(crate) path: &'s str,
    /// The text of the source.
    pub(crate) text: &'s str,
    /// The range of the span in the text.
    pub(crate) range: Range<usize>,
    /// The line in which the span starts, from 1.
    pub(crate) line: usize,
    /// The start of this line in the text.
    pub(crate) line_start: usize,
}

#[derive(Clone, Debug)]
struct Source {
    path: String,
    text: String,
    start: u32,
    /// The starts of all lines except the first, created lazily.
    lines: OnceLock<Vec<u32>>,
    /// The reason why the source can't be read, and its location in the text.
    error: Option<(Problem, Range<usize>)>,
}

impl Source {
    /// The reason why the source can't be read.
    fn diagnostic(&self) -> Option<Diagnostic> {
        let (problem, range) = self.error.as_ref()?;
        let start = Span { start: self.start, end: self.start };
        Some(Diagnostic::new(problem.clone(), start.part(range.clone())))
    }

    /// The range of a span in the text.
    fn range(&self, span: Span) -> Range<usize> {
        let start = (span.start.saturating_sub(self.start) as usize).min(self.text.len());
        let end = (span.end.saturating_sub(self.start) as usize).clamp(start, self.text.len());
        start..end
    }

    /// The number (from 0) of the line that contains a position, and the start of that line.
    fn line(&self, at: usize) -> (usize, usize) {
        let starts = self
            .lines
            .get_or_init(|| self.text.match_indices('\n').map(|(newline, _)| offset(newline + 1)).collect());
        let line = starts.partition_point(|start| *start as usize <= at);
        (line, line.checked_sub(1).map_or(0, |before| starts[before] as usize))
    }
}

/// All sources of a run, in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    sources: Vec<Source>,
}

impl SourceMap {
    /// Adds a text with the path that diagnostics display.
    ///
    /// Fails if the text can't be read (invalid UTF-8, a byte order mark, too long), or if all sources together exceed
    /// 4 GiB. The readable part of the text is still added, for display.
    #[allow(clippy::result_large_err)] // called once per file
    pub fn add(&mut self, path: impl Into<String>, bytes: Vec<u8>) -> Result<SourceId, Diagnostic> {
        let start = self.next_start();
        let id = SourceId(offset(self.sources.len()));
        let len = bytes.len();
        let total_fits =
            u32::try_from(len + MAX_SOURCE_LEN).is_ok_and(|len| start.checked_add(len).is_some());
        let too_long = len > MAX_SOURCE_LEN || !total_fits;
        let (text, error) = match String::from_utf8(if too_long { Vec::new() } else { bytes }) {
            _ if too_long => {
                (String::new(), Some((Problem::SourceTooLong { len, max: MAX_SOURCE_LEN }, 0..0)))
            }
            Ok(text) => {
                let has_bom = text.starts_with('\u{feff}');
                (text, has_bom.then(|| (Problem::ByteOrderMark, 0..'\u{feff}'.len_utf8())))
            }
            Err(error) => {
                let valid = error.utf8_error().valid_up_to();
                let problem = Problem::InvalidUtf8 { byte: error.as_bytes()[valid] };
                let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
                (text, Some((problem, valid..valid + '\u{fffd}'.len_utf8())))
            }
        };
        let source = Source { path: path.into(), text, start, lines: OnceLock::new(), error };
        let diagnostic = source.diagnostic();
        self.sources.push(source);
        diagnostic.map_or(Ok(id), Err)
    }

    /// The start of the next source. Sources don't touch, so each position belongs to one source.
    fn next_start(&self) -> u32 {
        let end = |last: &Source| last.start.saturating_add(offset(last.text.len()));
        self.sources.last().map_or(0, |last| end(last).saturating_add(1))
    }

    /// The errors of the sources that can't be read, as [`Self::add`] returned them.
    pub fn errors(&self) -> impl Iterator<Item = Diagnostic> {
        self.sources.iter().filter_map(Source::diagnostic)
    }

    /// A copy with the same ids, but with new text for some of the sources. The [`Self::errors`] of the copy may
    /// differ.
    #[must_use]
    pub fn with_texts(&self, texts: &BTreeMap<SourceId, String>) -> Self {
        let mut sources = Self::default();
        for (at, source) in self.sources.iter().enumerate() {
            if let Some(text) = texts.get(&SourceId(offset(at))) {
                // Add invalid text as well, to preserve the ids.
                let _ = sources.add(source.path.clone(), text.clone().into_bytes());
            } else {
                // Copy an unreadable source unchanged, because its text isn't the text that was added.
                let start = sources.next_start();
                sources.sources.push(Source { start, ..source.clone() });
            }
        }
        sources
    }

    /// A copy with other paths for some of the sources.
    #[must_use]
    pub fn with_paths(&self, paths: impl Iterator<Item = (SourceId, String)>) -> Self {
        let mut sources = self.clone();
        for (SourceId(index), path) in paths {
            sources.sources[index as usize].path = path;
        }
        sources
    }

    /// The text of a source.
    pub fn text(&self, id: SourceId) -> &str {
        &self.sources[id.0 as usize].text
    }

    /// The path of a source, as given.
    pub fn path(&self, id: SourceId) -> &str {
        &self.sources[id.0 as usize].path
    }

    /// The span of a whole source.
    pub fn span(&self, id: SourceId) -> Span {
        let source = &self.sources[id.0 as usize];
        Span { start: source.start, end: source.start + offset(source.text.len()) }
    }

    /// The source that contains `span`.
    pub fn source_of(&self, span: Span) -> SourceId {
        let after = self.sources.partition_point(|source| source.start <= span.start);
        SourceId(offset(after.saturating_sub(1)))
    }

    /// True if `span` is within one source and doesn't split a character.
    pub fn contains(&self, span: Span) -> bool {
        let Some(source) = self.source(span) else { return false };
        let within = |at: u32| Some(at.checked_sub(source.start)? as usize);
        let (Some(start), Some(end)) = (within(span.start), within(span.end)) else { return false };
        source.text.get(start..end).is_some()
    }

    /// The text within `span`.
    pub fn slice(&self, span: Span) -> &str {
        self.source(span).and_then(|source| source.text.get(source.range(span))).unwrap_or("")
    }

    /// The line and the column of the start of `span`.
    pub fn position(&self, span: Span) -> Position {
        let Some(source) = self.source(span) else { return Position { line: 1, column: 1 } };
        let at = source.range(span).start;
        let (line, start) = source.line(at);
        let column = source.text.get(start..at).map_or(0, |line| line.chars().count()) + 1;
        Position { line: line + 1, column }
    }

    /// The path and the text of the source that contains `span`, and the line in which `span` starts. Searches only
    /// once, which is faster than a search for each of these values.
    pub(crate) fn located(&self, span: Span) -> Located<'_> {
        let source = &self.sources[self.source_of(span).0 as usize];
        let range = source.range(span);
        let (line, line_start) = source.line(range.start);
        Located { path: &source.path, text: &source.text, range, line: line + 1, line_start }
    }

    /// The source that contains `span`; `None` if there are no sources.
    fn source(&self, span: Span) -> Option<&Source> {
        self.sources.get(self.source_of(span).0 as usize)
    }
}

/// The file name of `path` without its extension.
pub fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_lines_and_characters_in_each_source() {
        let mut sources = SourceMap::default();
        let first = sources.add("a", "é b\r\nc".into()).expect("valid");
        let second = sources.add("b", "\nxyz".into()).expect("valid");
        let at = |id, range| sources.span(id).part(range);
        assert_eq!(sources.position(at(first, 3..4)), Position { line: 1, column: 3 });
        assert_eq!(sources.position(at(first, 6..7)), Position { line: 2, column: 1 });
        assert_eq!(sources.position(at(second, 3..4)), Position { line: 2, column: 3 });
        assert_eq!(sources.slice(at(second, 1..4)), "xyz");
        assert_eq!(sources.source_of(at(first, 7..7)), first, "the end of a source belongs to the source");
    }

    #[test]
    fn rejects_unreadable_texts_with_their_location() {
        let mut sources = SourceMap::default();
        let error = sources.add("a", b"ok\n\xff\xfe".to_vec()).expect_err("invalid");
        assert_eq!(error.problem, Problem::InvalidUtf8 { byte: 0xff });
        assert_eq!(sources.position(error.span), Position { line: 2, column: 1 });
        assert_eq!(
            sources.add("b", "\u{feff}uint8 a".into()).expect_err("a BOM").problem,
            Problem::ByteOrderMark
        );
        let error = sources.add("c", vec![b' '; MAX_SOURCE_LEN + 1]).expect_err("too long");
        assert!(matches!(error.problem, Problem::SourceTooLong { .. }));
    }

    #[test]
    fn a_copy_with_other_texts_has_the_errors_at_their_new_locations() {
        let mut sources = SourceMap::default();
        let first = sources.add("a", "uint8 a\n".into()).expect("valid");
        sources.add("b", b"ok\n\xff".to_vec()).expect_err("invalid");
        let last = sources.add("c", "uint8 c\n".into()).expect("valid");
        let texts = [(first, "uint8 longer\n".to_owned()), (last, "\u{feff}uint8 c\n".to_owned())];
        let changed = sources.with_texts(&texts.into());
        let place = |found: Diagnostic| {
            let path = changed.path(changed.source_of(found.span));
            (path, changed.position(found.span).line, found.problem)
        };
        let found: Vec<_> = changed.errors().map(place).collect();
        let expected = [("b", 2, Problem::InvalidUtf8 { byte: 0xff }), ("c", 1, Problem::ByteOrderMark)];
        assert_eq!(found, expected);
        assert_eq!(changed.with_texts(&[(last, String::new())].into()).errors().count(), 1);
    }
}
