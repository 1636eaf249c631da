//! `PX-FSF-01`: flags of `FailsafeFlags` name a failure.

use uavspec_runtime::Scalar;

use super::{Check, Example, Levels, Measured, Rule, Sink, Subject};
use crate::diagnostic::Level;
use crate::schema::{Element, Field};

pub(super) const RULE: Rule = Rule {
    id: "PX-FSF-01",
    purpose: "A flag of FailsafeFlags is named after the failure that it tells of, so that false means that \
              all is well. The failsafe state machine and its simulation take every true flag for a failure.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "FailsafeFlags.msg",
        text: "# What the failsafe state machine decides on\n\n\
               uint64 timestamp  # [us] Time since system start\n\n\
               bool tow_rope_attached  # Tow rope attached\n",
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

/// Words that name a failure, in the names of flags.
const FAILURES: &str = "breached breach broken corrupt corrupted critical denied disconnected empty error exceeded \
    failed failing failure fault faulty high imbalanced inconsistent invalid inaccurate loss lost \
    low missing overheated overload overloaded rejected spoofed stale stuck timeout triggered \
    unavailable unhealthy unsafe unstable violated violation warning weak";

/// Masks over the flight modes: they require, and tell of no failure.
pub(super) const REQUIREMENT: &str = "mode_req_";

/// Whether a message is the one that both rules on flags are about.
pub(super) fn applies(subject: &Subject<'_>) -> bool {
    subject.is_px4_message() && subject.message.name == "FailsafeFlags"
}

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !applies(subject) {
        return;
    }
    for field in subject.message.fields.iter().filter(|field| !names_a_failure(field)) {
        sink.report(
            field.span,
            format!("`{}` names no failure", field.name),
            "name it so that false means no failure: `…_invalid`, `…_lost`, `…_unhealthy`",
        );
    }
}

fn names_a_failure(field: &Field) -> bool {
    field.ty.element != Element::Scalar(Scalar::Bool)
        || field.name.starts_with(REQUIREMENT)
        || field.name.split('_').any(|word| FAILURES.split(' ').any(|known| known == word))
}
