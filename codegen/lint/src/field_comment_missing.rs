//! `field-comment-missing`: a field without a comment.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-comment-missing",
    statement: "A field without a comment.",
    why: "The name alone doesn't say what `true` means, who sets the field or what the value is relative to.",
    fix: "Describe the field in a comment.",
    levels: Levels { px4: Some(Level::Note), strict: Some(Level::Warning) },
    bad: glider!["float32 sink"],
    good: glider!["float32 sink  # [m/s] Sink rate, down is positive"],
    measured: Some(Measured { findings: 464, sample: 30, right: 28 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for field in subject.message.fields.iter().filter(|field| field.description.is_empty()) {
        sink.report(
            field.span,
            format!("`{}` has no comment", field.name),
            "add a comment that explains what it means",
        );
    }
}
