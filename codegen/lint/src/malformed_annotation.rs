//! `malformed-annotation`: an annotation with invalid arguments.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "malformed-annotation",
    statement: "An annotation with invalid arguments.",
    why: "The annotation is treated as text, so the value is not checked.",
    fix: "Write the arguments that the annotation expects.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] [@range 0 to 10] Sink rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] [@range 0, 10] Sink rate\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
