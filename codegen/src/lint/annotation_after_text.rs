//! `annotation-after-text`: annotations stand at the head of a comment.

use super::{Check, Example, Levels, Measured, Rule};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::finding::Edit;
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

fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let Problem::AnnotationAfterText { meant, head: Some(head), .. } = &diagnostic.problem else {
        return Vec::new();
    };
    let place = diagnostic.span;
    let before = Span { start: head.start, end: place.start };
    let kept = sources.slice(before).trim_end().len();
    let annotation = Edit { span: *head, text: format!("{meant} ") };
    vec![annotation, Edit { span: before.part(kept..kept).to(place), text: String::new() }]
}
