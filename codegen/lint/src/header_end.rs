//! `header-end`: a short description with a missing or superfluous full stop.

use uavspec_schema::msg::ast::{Comment, Line};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "header-end",
    statement: "A short description that doesn't follow PX4's standard, which requires one line without a \
        full stop.",
    why: "Without a full stop or an empty comment line, a multi-line short description runs into the text \
        below it.",
    fix: "Remove the full stop from a one-line description. End a longer description with a full stop, or separate it \
        with a `#` line.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider.\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    good: glider![],
    measured: Some(Measured { findings: 32, sample: 30, right: 30 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let text =
        |line: &&'_ Line<'_>| line.comment.as_deref().is_some_and(|comment| !comment.text.trim().is_empty());
    let head = subject.part.lines.iter().take_while(|line| line.item.is_none() && line.comment.is_some());
    let paragraph: Vec<&Comment<'_>> = head
        .skip_while(|line| !text(line))
        .take_while(text)
        .filter_map(|line| line.comment.as_deref())
        .filter(|comment| !comment.text.starts_with(" TOPICS "))
        .collect();
    let [first, .., last] = &paragraph[..] else {
        if let [only] = &paragraph[..]
            && is_one_sentence(only.text)
        {
            let help = "remove it: a one-line short description has no full stop";
            sink.report(end(only), "full stop after the short description", help);
        }
        return;
    };
    if last.text.ends_with(|c: char| c.is_alphanumeric()) {
        sink.report(
            first.span.to(last.span),
            "multi-line short description without a full stop",
            "add a full stop, or separate the short description with a `#` line",
        );
    }
}

/// True if a text is one sentence that ends with a full stop.
fn is_one_sentence(text: &str) -> bool {
    text.strip_suffix('.')
        .is_some_and(|text| !text.contains(". ") && !text.ends_with(['.', ')']) && !text.ends_with("etc"))
}

fn end(comment: &Comment<'_>) -> uavspec_schema::source::Span {
    let len = comment.text.len();
    comment.span.part(len..len + 1)
}
