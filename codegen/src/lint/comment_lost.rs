//! `comment-lost`: comments that no documentation shows.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use super::topics;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::msg::ast::Comment;
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
    measured: Some(Measured {
        findings: 16,
        sample: 16,
        right: 15,
        remark: "the other is a line that was switched off",
    }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    let lines = &subject.part.lines;
    let head = lines.iter().take_while(|line| line.item.is_none() && line.comment.is_some()).count();
    let mut lists = topics::lines(subject).map(|line| line.span).peekable();
    let mut block = Block::default();
    for line in &lines[head..] {
        while lists.next_if(|list| list.start < line.span.start).is_some() {}
        if lists.peek() == Some(&line.span) {
            block.is_of_topics = true;
        } else if let Some(comment) = line.comment.as_deref().filter(|_| line.item.is_none()) {
            block.comment(comment);
        } else {
            if line.is_blank() {
                block.end(sink);
            }
            block = Block { is_after_item: line.item.is_some(), ..Block::default() };
        }
    }
    block.end(sink);
}

/// Comments on lines of their own, one below the other.
#[derive(Default)]
struct Block {
    /// From the first to the last that says anything.
    place: Option<Span>,
    /// Whether the line before is a declaration, or goes on with its comment.
    is_after_item: bool,
    /// Whether a list of topics stands among them, which they may be about.
    is_of_topics: bool,
}

impl Block {
    fn comment(&mut self, comment: &Comment<'_>) {
        if comment.is_directive() || self.is_after_item && comment.column > 0 {
            return;
        }
        self.is_after_item = false;
        if !comment.text.trim().is_empty() {
            self.place = Some(self.place.map_or(comment.span, |place| place.to(comment.span)));
        }
    }

    /// Reports a block that nothing stands below.
    fn end(&self, sink: &mut Sink<'_>) {
        if let Some(place) = self.place.filter(|_| !self.is_of_topics) {
            let help = "remove the empty line between it and what it is about, or the comment";
            sink.report(place, "a comment that stands for nothing", help);
        }
    }
}
