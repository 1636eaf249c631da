//! The `# TOPICS a b` lines of PX4 messages.

use uavspec_schema::directive;
use uavspec_schema::msg::ast::Line;
use uavspec_schema::source::{SourceMap, Span};

use super::subject::Subject;

/// The start of the comment in a `# TOPICS` line.
const MARK: &str = " TOPICS";

/// The lines of a message that list topics. A list may be empty.
pub(super) fn lines<'a>(subject: &Subject<'a>) -> impl Iterator<Item = &'a Line<'a>> {
    let is_list = |line: &&Line<'_>| {
        let comment = line.comment.as_deref().filter(|comment| line.item.is_none() && comment.column == 0);
        let list = comment.and_then(|comment| comment.text.strip_prefix(MARK));
        list.is_some_and(|list| list.is_empty() || list.starts_with(' '))
    };
    subject.part.lines.iter().filter(is_list)
}

/// The topics in a line, each with its span.
pub(super) fn words<'a>(line: &'a Line<'_>) -> impl Iterator<Item = (&'a str, Span)> {
    let comment = line.comment.as_deref();
    let text = comment.map_or("", |comment| comment.text);
    let place = comment.map_or(line.span, |comment| comment.span);
    let list = text.strip_prefix(MARK).unwrap_or_default();
    let mut at = 1 + text.len() - list.len();
    list.split([' ', '\t']).filter_map(move |word| {
        let start = at;
        at += word.len() + 1;
        (!word.is_empty()).then(|| (word, place.part(start..start + word.len())))
    })
}

/// The span to delete in order to remove the topic at `word`. The span contains the word with the spaces around it, or
/// the whole line if there is no other topic. `None` if deleting the line would make a comment below it belong to
/// another declaration.
///
/// The search is limited to the neighbouring text, because a line may list any number of topics.
pub(super) fn removal(word: Span, sources: &SourceMap) -> Option<Span> {
    let whole = sources.span(sources.source_of(word));
    let before = sources.slice(Span { start: whole.start, end: word.start });
    let after = sources.slice(Span { start: word.end, end: whole.end });
    let kept = before.trim_end_matches([' ', '\t']);
    let rest = after.trim_start_matches([' ', '\t']);
    let line_start = kept.strip_suffix("# TOPICS").filter(|above| above.is_empty() || above.ends_with('\n'));
    let Some(above) = line_start else {
        return Some(whole.part(kept.len()..kept.len()).to(word));
    };
    let below = if rest.is_empty() {
        rest
    } else if let Some(below) = rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix('\n')) {
        below
    } else if !rest.starts_with(|c: char| c.is_ascii_alphabetic()) || rest.starts_with(directive::MARK) {
        return None;
    } else {
        // More topics follow.
        return Some(Span { start: word.start, end: whole.end - length(rest) });
    };
    let line = |text: &str| text.split('\n').next().unwrap_or_default().trim().to_owned();
    let last = above.strip_suffix('\n').map(|above| (above, above.rsplit('\n').next().unwrap_or_default()));
    let is_after_empty = last.is_some_and(|(_, line)| line.trim().is_empty());
    let next = line(below);
    if is_after_empty && next.starts_with('#') {
        return None;
    }
    // If two consecutive empty lines would remain, one of them is removed. An empty line at the end is also removed.
    let start = match last {
        Some((above, empty)) if is_after_empty && next.is_empty() => above.len() - empty.len(),
        _ => above.len(),
    };
    Some(Span { start: whole.start + length(&above[..start]), end: whole.end - length(below) })
}

/// The length of a text. Sources are shorter than `u32::MAX`.
fn length(text: &str) -> u32 {
    u32::try_from(text.len()).unwrap_or(u32::MAX)
}
