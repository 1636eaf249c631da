//! `PX-FSF-02`: a flag of `FailsafeFlags` without a comment.

use uavspec_runtime::Scalar;
use uavspec_schema::Element;

use super::prelude::*;
use super::px_fsf_01;

pub(super) const RULE: Rule = Rule {
    id: "PX-FSF-02",
    statement: "A FailsafeFlags flag without a comment.",
    why: "The failsafe simulation shows the comment as the flag's label. Without a comment, the \
        check box has no label.",
    fix: "Describe the failure in a comment.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "FailsafeFlags.msg",
        text: "# Input flags of the failsafe state machine\n\n\
               uint64 timestamp  # [us] Time since system start\n\nbool tow_rope_lost\n",
    },
    good: Example {
        path: "FailsafeFlags.msg",
        text: "# Input flags of the failsafe state machine\n\n\
               uint64 timestamp  # [us] Time since system start\n\n\
               bool tow_rope_lost  # Tow rope lost\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !px_fsf_01::applies(subject) {
        return;
    }
    for field in &subject.message.fields {
        let is_flag = matches!(field.ty.element, Element::Scalar(Scalar::Bool | Scalar::UInt8));
        if is_flag && field.description.is_empty() && !field.name.starts_with(px_fsf_01::REQUIREMENT) {
            sink.report(
                field.span,
                format!("`{}` has no comment", field.name),
                "describe the failure in a comment: the failsafe simulation shows it as the label",
            );
        }
    }
}
