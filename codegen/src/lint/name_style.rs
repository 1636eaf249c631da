//! `name-style`: names that some tools reject.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "name-style",
    statement: "A field that is not in lower_snake_case, or a constant that is not in UPPER_SNAKE_CASE.",
    why: "ROS 2 rejects other names, and also names that contain `__` or end with `_`, so the message can't be \
        bridged.",
    fix: "Rename the field or the constant.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sinkRate  # [m/s] Sink rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink_rate  # [m/s] Sink rate\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
