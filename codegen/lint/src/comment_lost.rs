//! `comment-lost`: a comment that isn't part of any documentation.

use uavspec_schema::msg::ast::Comment;
use uavspec_schema::source::Span;

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "comment-lost",
    statement: "A comment that belongs neither to the message nor to a declaration.",
    why: "The comment doesn't appear in the documentation. Often, an empty line separates it from the text \
        or declaration that it belongs to.",
    fix: "Remove the empty line, or replace it with a `#` line. Delete the comment if it is obsolete.",
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
    measured: Some(Measured { findings: 16, sample: 16, right: 15 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
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

/// Consecutive lines that contain only a comment.
#[derive(Default)]
struct Block {
    /// The span from the first to the last comment with text.
    place: Option<Span>,
    /// True if the previous line is a declaration, or continues a declaration's comment.
    is_after_item: bool,
    /// True if one of the comments is a list of topics. If so, the other comments in the block may describe the topics.
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

    /// Reports a block that has no declaration below it.
    fn end(&self, sink: &mut Sink<'_>) {
        if let Some(place) = self.place.filter(|_| !self.is_of_topics) {
            let help = "remove the empty line between the comment and its declaration, or delete the comment";
            sink.report(place, "the comment belongs to no declaration", help);
        }
    }
}
