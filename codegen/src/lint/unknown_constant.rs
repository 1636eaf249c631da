//! `unknown-constant`: an annotation that names a constant that isn't there.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "unknown-constant",
    purpose: "A word as the value of an annotation is the name of a constant of the message, or of a limit \
              such as `UINT8_MAX`. With any other the annotation says nothing.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 crew  # [-] [@invalid CREW_UNKNOWN] People on board\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 crew  # [-] [@invalid UINT8_MAX] People on board\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
