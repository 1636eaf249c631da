//! Rendering of diagnostics and findings as text: path, line, source line, caret and hint.
//!
//! ```
//! use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read, render};
//!
//! let mut sources = SourceMap::default();
//! let id = sources.add("Wind.msg", "float32 speed  # [parsec] Speed\n".into()).unwrap();
//! let (_, diagnostics) = read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]);
//! let text = render::render(&diagnostics, &sources, false);
//! assert!(text.starts_with("warning[unknown-unit]: unknown unit `parsec`\n --> Wind.msg:1:18"));
//! ```

use std::borrow::Cow;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level as Title, Renderer, Snippet};

use crate::diagnostic::{Diagnostic, Level};
use crate::finding::Finding;
use crate::parallel::in_parts;
use crate::prose::visible;
use crate::source::{Located, SourceMap, Span};
use crate::terminal::{Command, guarded, shown};

/// Maximum number of diagnostics shown per source. A file with more diagnostics is probably not a definition.
const MAX_PER_SOURCE: usize = 200;

/// Maximum length in bytes of a message or hint, which may quote text of any length.
const MAX_TEXT_LEN: usize = 400;

/// Maximum number of bytes quoted after the marked part of a line.
const MAX_REST_LEN: usize = 200;

/// Renders `diagnostics` ordered by source and position, with colours if `styled`.
pub fn render(diagnostics: &[Diagnostic], sources: &SourceMap, styled: bool) -> String {
    let mut ordered: Vec<Finding> = diagnostics.iter().map(Finding::from).collect();
    ordered.sort_by_key(|finding| finding.span);
    findings(&ordered, sources, styled)
}

/// Renders `findings` in the given order, with colours if `styled`. Consecutive findings that differ only in category
/// are shown as one.
pub fn findings(findings: &[Finding], sources: &SourceMap, styled: bool) -> String {
    let is_in_same_source =
        |left: &Finding, right: &Finding| sources.source_of(left.span) == sources.source_of(right.span);
    let by_source: Vec<&[Finding]> = findings.chunk_by(is_in_same_source).collect();
    in_parts(&by_source, |by_source| in_sources(by_source, sources, styled)).concat()
}

/// Renders the findings of several sources.
fn in_sources(by_source: &[&[Finding]], sources: &SourceMap, styled: bool) -> String {
    let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for in_source in by_source {
        for same in in_source.chunk_by(Finding::is_same_change).take(MAX_PER_SOURCE) {
            text += &renderer.render(&[group(same, sources)]);
            text.push('\n');
        }
        let count = in_source.chunk_by(Finding::is_same_change).count();
        if let Some(more) = count.checked_sub(MAX_PER_SOURCE).filter(|more| *more > 0) {
            let path = shown(sources.path(sources.source_of(in_source[0].span)));
            text.extend(["… and ", &more.to_string(), " more in ", &path, "\n"]);
        }
    }
    text
}

/// Renders another tool's error at a source location, without the `error: ` prefix and without colours.
pub fn plain(message: &str, span: Span, sources: &SourceMap) -> String {
    let snippet = quote(span, AnnotationKind::Primary, String::new(), sources);
    let message = guarded(message);
    let text = Renderer::plain().render(&[Title::ERROR.primary_title(message).element(snippet)]);
    text.strip_prefix("error: ").map(str::to_owned).unwrap_or(text)
}

/// The rendered form of a group of findings that differ only in category.
fn group<'a>(same: &[Finding], sources: &'a SourceMap) -> Group<'a> {
    let finding = &same[0];
    let level = same.iter().map(|finding| finding.level).max().unwrap_or(Level::Note);
    let title = match level {
        Level::Error => Title::ERROR,
        Level::Warning => Title::WARNING,
        Level::Note => Title::NOTE,
    };
    let title = title.primary_title(shorten(&finding.message)).id(finding.rule);
    let mut group = Group::with_title(title);
    // Without categories, the help is the caret's label. With categories, there is a note for each category.
    let label = if finding.category.is_none() { shorten(&finding.help) } else { String::new() };
    match finding.sides {
        None => group = group.element(quote(finding.span, AnnotationKind::Primary, label, sources)),
        Some(sides) => {
            for (side, label) in [(sides.old, "before"), (sides.new, "now")] {
                let Some(span) = side else { continue };
                group = group.element(quote(span, AnnotationKind::Primary, label.to_owned(), sources));
            }
        }
    }
    for (span, label) in &finding.related {
        group = group.element(quote(*span, AnnotationKind::Context, shorten(label), sources));
    }
    for finding in same {
        let Some(category) = finding.category else { continue };
        group = group.element(Title::NOTE.with_name(category).message(shorten(&finding.help)));
    }
    group
}

/// A message, hint or label on one line.
fn shorten(text: &str) -> String {
    let mut text = shown(text);
    if text.len() > MAX_TEXT_LEN {
        text.truncate(floor_char_boundary(&text, MAX_TEXT_LEN));
        text.push('…');
    }
    text
}

/// The start of the character at a byte offset, or the end of the text. `str` has this function since Rust 1.91.
pub fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}

/// Quotes the lines that `span` touches, with a caret below. Only these lines are passed to the renderer, so the
/// rendering time doesn't depend on the size of the file.
fn quote(
    span: Span,
    kind: AnnotationKind,
    label: String,
    sources: &SourceMap,
) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
    let Located { path, text, range, line, line_start: first } = sources.located(span);
    let end_of_line = |from: usize| text[from..].find('\n').map_or(text.len(), |at| from + at);
    // A span that covers several lines is marked only on its first line.
    let last = end_of_line(range.start);
    let end = range.end.min(last);
    // The renderer counts columns from the start of the line, so an overlong line is truncated only at its end.
    let last = floor_char_boundary(text, last.min(end + MAX_REST_LEN));
    let range = range.start - first..end.clamp(range.start, last) - first;
    let (quoted, range) = visible_line(&text[first..last], range);
    Snippet::source(quoted)
        .path(shown(path))
        .line_start(line)
        .annotation(kind.span(range).label((!label.is_empty()).then_some(label)))
}

/// Replaces characters that a terminal or a CI system would interpret. Each becomes U+FFFD. Returns the new line, and
/// the byte range of the same characters in it. Each character keeps its column, so carets stay below the text that
/// they mark.
fn visible_line(line: &str, range: Range<usize>) -> (Cow<'_, str>, Range<usize>) {
    if line.bytes().all(Command::is_plain) {
        return (Cow::Borrowed(line), range);
    }
    // A line number precedes the line, so the text doesn't start a line.
    let (mut command, mut text, mut start, mut end) = (Command::Text, String::new(), None, None);
    for (at, character) in line.char_indices() {
        start = start.or((at >= range.start).then_some(text.len()));
        end = end.or((at >= range.end).then_some(text.len()));
        let is_command = command.is_completed_by(character);
        text.push(match character {
            _ if is_command => char::REPLACEMENT_CHARACTER,
            '\t' => '\t',
            // The renderer removes joiners.
            '\u{200d}' => char::REPLACEMENT_CHARACTER,
            _ => visible(character),
        });
    }
    let range = start.unwrap_or(text.len())..end.unwrap_or(text.len());
    (Cow::Owned(text), range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carets_stay_below_the_text_that_they_mark() {
        let mut sources = SourceMap::default();
        let line = "a\u{85}\u{202e}\u{1b}[1m##[error]é here\n";
        let id = sources.add("a\n::error::b", line.into()).expect("a source");
        let start = line.find("here").expect("the text");
        let span = sources.span(id).part(start..start + 4);
        let finding = Finding::new("unit-missing", Level::Warning, span, "\u{1b}[2J\n::error::c");
        let text = findings(&[finding], &sources, false);
        let lines: Vec<&str> = text.lines().collect();
        let column = |line: &str, text: &str| line.find(text).map(|at| line[..at].chars().count());
        let (excerpt, caret) = (column(lines[3], "here"), column(lines[4], "^^^^"));
        assert!(excerpt.is_some() && excerpt == caret, "{text}");
        assert_eq!(crate::terminal::guarded(&text), text);
        assert_eq!(lines[0], r"warning[unit-missing]: \u{1b}[2J\n::error::c");
        assert!(lines[1].contains(r"--> a\n::error::b:1:"), "{text}");
    }
}
