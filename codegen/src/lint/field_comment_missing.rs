//! `field-comment-missing`: a field that nobody explains.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "field-comment-missing",
    purpose: "A field has a comment. Its name alone leaves open what counts as true, who sets it and what it \
              is measured against.",
    levels: Levels { px4: Some(Level::Note), strict: Some(Level::Warning) },
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\nfloat32 sink\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] Sink rate, down is positive\n",
    },
    measured: Some(Measured {
        findings: 464,
        sample: 30,
        right: 28,
        remark: "the others stand under a heading that says it",
    }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    for field in subject.message.fields.iter().filter(|field| field.description.is_empty()) {
        sink.report(
            field.span,
            format!("nothing is said of `{}`", field.name),
            "say in a comment what it means",
        );
    }
}
