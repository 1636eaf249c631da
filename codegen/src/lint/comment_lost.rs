//! `comment-lost`: comments that no documentation shows.

use super::{Check, Example, Levels, Rule, Sink, Subject, topics};
use crate::diagnostic::Level;
use crate::source::Span;

pub(super) const RULE: Rule = Rule {
    id: "comment-lost",
    purpose: "A comment on lines of its own describes the message at the head of its file, or stands above \
              declarations without an empty line between. Any other gets into no documentation: most often an \
              empty line cuts it off from what it is about.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\n# Sent by its logger once a second.\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n#\n# Sent by its logger once a second.\n\n\
               uint64 timestamp  # [us] Time since system start\n",
    },
    measured: None,
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    let lines = &subject.part.lines;
    let head = lines.iter().take_while(|line| line.item.is_none() && line.comment.is_some()).count();
    let mut lists = topics::lines(subject).map(|line| line.span).peekable();
    let mut block: Option<Span> = None;
    let mut is_after_item = false;
    for line in &lines[head..] {
        while lists.next_if(|list| list.start < line.span.start).is_some() {}
        let is_list = lists.peek() == Some(&line.span);
        if let Some(comment) = line.comment.as_deref().filter(|_| line.item.is_none()) {
            let goes_on = is_after_item && comment.column > 0;
            if !comment.is_directive() && !is_list && !goes_on {
                is_after_item = false;
                if !comment.text.trim().is_empty() {
                    block = Some(block.map_or(comment.span, |block| block.to(comment.span)));
                }
            }
            continue;
        }
        is_after_item = line.item.is_some();
        if let Some(lost) = block.take().filter(|_| line.is_blank()) {
            report(lost, sink);
        }
    }
    if let Some(lost) = block {
        report(lost, sink);
    }
}

fn report(span: Span, sink: &mut Sink<'_>) {
    let help = "remove the empty line between it and what it is about, or the comment";
    sink.report(span, "a comment that stands for nothing", help);
}
