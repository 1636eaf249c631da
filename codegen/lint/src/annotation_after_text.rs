//! `annotation-after-text`: an annotation after the text of a comment.

use uavspec_schema::diagnostic::Problem;
use uavspec_schema::msg::annotation::is_bracketed;
use uavspec_schema::source::Span;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "annotation-after-text",
    statement: "An annotation after the text of a comment.",
    why: "PX4's documentation generator reads annotations only at the start of a comment. The generator \
        prints later annotations as text, and other tools ignore them.",
    fix: "Move the annotation to the start of the comment.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32 sink  # Sink rate [@range 0, 10], down is positive"],
    good: glider!["float32 sink  # [@range 0, 10] Sink rate, down is positive"],
    measured: Some(Measured { findings: 8, sample: 8, right: 7 }),
    check: Check::Reader(fix),
};

/// The maximum length of the text before an annotation. The limit is needed because a comment may have any number of
/// brackets and annotations.
const MAX_TEXT_LEN: usize = 2_000;

fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let Problem::AnnotationAfterText { expected, head: Some(head), .. } = &diagnostic.problem else {
        return Vec::new();
    };
    let place = diagnostic.span;
    let before = Span { start: head.start, end: place.start };
    let end = sources.span(sources.source_of(place)).end;
    if !is_bracketed(expected)
        || !can_close(sources.slice(before), sources.slice(Span { start: place.end, end }))
    {
        return Vec::new();
    }
    let text = sources.slice(before);
    let kept = text.trim_end().len();
    let annotation = Edit { span: *head, text: format!("{expected} ") };
    vec![annotation, Edit { span: before.part(kept..kept).to(place), text: String::new() }]
}

/// True if the text before and after an annotation keeps its meaning when the annotation is removed.
fn can_close(before: &str, after: &str) -> bool {
    let count = |bracket: char| before.matches(bracket).count();
    // If several annotations have the same kind, the last annotation takes effect, so the first annotation must be
    // moved first.
    before.len() <= MAX_TEXT_LEN
        && !before.contains("[@")
        && !before.contains("(@")
        // The text on both sides must not join to form an annotation or a directive.
        && count('[') == count(']')
        && count('(') == count(')')
        && !before.trim_end().ends_with(['#', '/', '-'])
        && (after.is_empty() || after.starts_with([' ', '\t', '\r', '\n', '.', ',', ';']))
}
