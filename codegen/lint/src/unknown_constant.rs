//! `unknown-constant`: an annotation that refers to an unknown constant.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "unknown-constant",
    statement: "An annotation that refers to an unknown constant.",
    why: "The annotation has no effect.",
    fix: "Use the name of a constant in the message, or a limit such as `UINT8_MAX`.",
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
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
