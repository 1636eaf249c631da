//! `comment-continued`: a comment that continues below its declaration.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "comment-continued",
    statement: "A field or constant whose comment continues on the next line.",
    why: "uavspec joins the lines, but PX4's documentation shows only the first.",
    fix: "Write the whole comment on the line of the declaration.",
    levels: Levels::both(Level::Note),
    bad: glider!["float32 sink  # [m/s] Sink rate,", "              # down is positive"],
    good: glider!["float32 sink  # [m/s] Sink rate, down is positive"],
    measured: Some(Measured { findings: 15, sample: 15, right: 15 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let mut is_after_item = false;
    for line in &subject.part.lines {
        let comment =
            line.comment.as_deref().filter(|comment| line.item.is_none() && !comment.is_directive());
        match comment {
            Some(comment) if is_after_item && comment.column > 0 => {
                if !comment.text.trim().is_empty() {
                    sink.report(
                        comment.span,
                        "the comment continues below its declaration",
                        "write it on the line of the declaration: PX4's documentation doesn't show this line",
                    );
                }
            }
            Some(comment) => is_after_item &= comment.column == 0 && comment.text.starts_with(" TOPICS "),
            None if line.item.is_some() => is_after_item = true,
            None => is_after_item &= !line.is_blank(),
        }
    }
}
