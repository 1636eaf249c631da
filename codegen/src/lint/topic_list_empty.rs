//! `topic-list-empty`: a list of topics without any.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use super::topics;
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "topic-list-empty",
    purpose: "A line `# TOPICS` names at least one topic. Without any it is a comment, which the documentation \
              shows as a text.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n# TOPICS\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               # TOPICS glider tow_plane\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4_message() {
        return;
    }
    for line in topics::lines(subject).filter(|line| topics::words(line).next().is_none()) {
        sink.report(line.span, "a list of no topics", "name the topics behind it, or remove the line");
    }
}
