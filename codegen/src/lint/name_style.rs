//! `name-style`: names in the style that all tools take.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "name-style",
    purpose: "Fields are in lower_snake_case and constants in UPPER_SNAKE_CASE, without `__` and without `_` \
              at the end. ROS 2 refuses any other name, so the message can't be bridged.",
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
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
