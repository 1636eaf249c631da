//! Diagnostics as text: path, line, the line itself, a caret and a hint.

use std::fmt::Write as _;

use annotate_snippets::{AnnotationKind, Group, Level as Title, Renderer, Snippet};

use super::{Diagnostic, Level};
use crate::source::{SourceMap, Span};

/// How many diagnostics of one source are shown: what stands there is then no definition.
const MAX_PER_SOURCE: usize = 200;

/// Longest message or hint, in bytes: what definitions have in them may be of any length.
const MAX_TEXT_LEN: usize = 400;

/// How much of a line is quoted after what is marked in it, in bytes.
const MAX_REST_LEN: usize = 200;

/// Renders `diagnostics` in the order of their sources and places, with colours where `styled`.
pub fn render(diagnostics: &[Diagnostic], sources: &SourceMap, styled: bool) -> String {
    let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
    let mut ordered: Vec<&Diagnostic> = diagnostics.iter().collect();
    ordered.sort_by_key(|diagnostic| diagnostic.span);
    let mut text = String::new();
    let by_source = |left: &&Diagnostic, right: &&Diagnostic| {
        sources.source_of(left.span) == sources.source_of(right.span)
    };
    for of_source in ordered.chunk_by(by_source) {
        for diagnostic in of_source.iter().take(MAX_PER_SOURCE) {
            text.push_str(&renderer.render(&[report(diagnostic, sources)]));
            text.push('\n');
        }
        if let Some(more) = of_source.len().checked_sub(MAX_PER_SOURCE).filter(|more| *more > 0) {
            let path = sources.path(sources.source_of(of_source[0].span));
            let _ = writeln!(text, "… and {more} more in {path}");
        }
    }
    text
}

/// An error of another tool at a place, in the same form.
#[cfg(feature = "cli")]
pub(crate) fn plain(message: &str, span: Span, sources: &SourceMap) -> String {
    let snippet = quote(span, AnnotationKind::Primary, String::new(), sources);
    let text = Renderer::plain().render(&[Title::ERROR.primary_title(message).element(snippet)]);
    text.strip_prefix("error: ").map(str::to_owned).unwrap_or(text)
}

fn report<'a>(diagnostic: &Diagnostic, sources: &'a SourceMap) -> Group<'a> {
    let title = match diagnostic.level() {
        Level::Error => Title::ERROR,
        Level::Warning => Title::WARNING,
    };
    let mut group = title
        .primary_title(shorten(diagnostic.problem.to_string()))
        .id(diagnostic.problem.code())
        .element(quote(diagnostic.span, AnnotationKind::Primary, shorten(diagnostic.hint()), sources));
    for (span, label) in &diagnostic.related {
        group = group.element(quote(*span, AnnotationKind::Context, shorten(label.clone()), sources));
    }
    group
}

fn shorten(mut text: String) -> String {
    if text.len() > MAX_TEXT_LEN {
        text.truncate(floor_char_boundary(&text, MAX_TEXT_LEN));
        text.push('…');
    }
    text
}

fn floor_char_boundary(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// The lines that `span` touches, and the caret under them. Only those are handed on, so that the
/// time to render doesn't depend on the length of the file.
fn quote(
    span: Span,
    kind: AnnotationKind,
    label: String,
    sources: &SourceMap,
) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
    let (text, range) = sources.locate(span);
    let first = text[..range.start].rfind('\n').map_or(0, |at| at + 1);
    let end_of_line = |from: usize| text[from..].find('\n').map_or(text.len(), |at| from + at);
    // A span over several lines is shown by its first.
    let last = end_of_line(range.start);
    let end = range.end.min(last);
    // The renderer counts columns from the start, so that only the end of an overlong line is left out.
    let last = floor_char_boundary(text, last.min(end + MAX_REST_LEN));
    Snippet::source(&text[first..last])
        .path(sources.path(sources.source_of(span)))
        .line_start(sources.position(span).line)
        .annotation(
            kind.span(range.start - first..end.clamp(range.start, last) - first)
                .label((!label.is_empty()).then_some(label)),
        )
}
