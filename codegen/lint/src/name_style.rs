//! `name-style`: names that some tools reject.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "name-style",
    statement: "A field that is not in lower_snake_case, or a constant that is not in UPPER_SNAKE_CASE.",
    why: "ROS 2 rejects names in other styles, and also names that contain `__` or end with `_`. A message with such \
        a name can't be bridged to ROS 2.",
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
