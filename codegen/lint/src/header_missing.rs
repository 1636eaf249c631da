//! `header-missing`: a message without a description.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "header-missing",
    statement: "A message without a description at the start of the file.",
    why: "The list of messages shows the first paragraph of the description. Without a description, it shows only the \
        name.",
    fix: "Start the file with a comment that says what the message is for.",
    levels: Levels::both(Level::Warning),
    bad: Example { path: "Glider.msg", text: "uint64 timestamp  # [us] Time since system start\n" },
    good: glider![],
    measured: Some(Measured { findings: 131, sample: 30, right: 30 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if subject.message.docs.summary.is_empty() {
        sink.report(
            subject.head(),
            format!("`{}` has no description", subject.message.name),
            "start the file with a comment that says what the message is for",
        );
    }
}
