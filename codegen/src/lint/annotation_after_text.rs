//! `annotation-after-text`: annotations stand at the head of a comment.

use super::rule::{Check, Levels, Measured, Rule};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::example::Example;
use crate::finding::Edit;
use crate::msg::annotation::is_bracketed;
use crate::source::{SourceMap, Span};

pub(super) const RULE: Rule = Rule {
    id: "annotation-after-text",
    purpose: "Annotations come first in a comment, then the text. PX4's documentation reads none that stand \
              after a word, and shows them as text.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # Sink rate [@range 0, 10], down is positive\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [@range 0, 10] Sink rate, down is positive\n",
    },
    measured: Some(Measured {
        findings: 8,
        sample: 8,
        right: 7,
        remark: "one stands in a command whose parameters can't be told apart",
    }),
    check: Check::Reader(fix),
};

/// Text before an annotation that is looked through for brackets; a comment may have any number of both.
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

/// Whether what stands `before` an annotation and what stands `after` it says the same once it is gone.
fn can_close(before: &str, after: &str) -> bool {
    let count = |bracket: char| before.matches(bracket).count();
    // Of two annotations that say the same thing the last counts, so the first goes first.
    before.len() <= MAX_TEXT_LEN
        && !before.contains("[@")
        && !before.contains("(@")
        // Brackets on both sides must not become an annotation of their own, nor words a directive.
        && count('[') == count(']')
        && count('(') == count(')')
        && !before.trim_end().ends_with(['#', '/', '-'])
        && (after.is_empty() || after.starts_with([' ', '\t', '\r', '\n', '.', ',', ';']))
}
