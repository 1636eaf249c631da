//! `PX-FSF-02`: flags of `FailsafeFlags` have a label.

use uavspec_runtime::Scalar;

use super::px_fsf_01;
use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Element;

pub(super) const RULE: Rule = Rule {
    id: "PX-FSF-02",
    purpose: "A flag of FailsafeFlags has a comment. It is the label under which the simulation of the \
              failsafe state machine shows it; without, there is a check box that says nothing.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "FailsafeFlags.msg",
        text: "# What the failsafe state machine decides on\n\n\
               uint64 timestamp  # [us] Time since system start\n\nbool tow_rope_lost\n",
    },
    good: Example {
        path: "FailsafeFlags.msg",
        text: "# What the failsafe state machine decides on\n\n\
               uint64 timestamp  # [us] Time since system start\n\n\
               bool tow_rope_lost  # Tow rope lost\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Message(check),
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
                format!("`{}` has no label", field.name),
                "say in a comment what has failed: the simulation shows it",
            );
        }
    }
}
