//! `unknown-unit`: a unit that nobody knows.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "unknown-unit",
    purpose: "Units are those of one list, each with one spelling. What is not on it can't be converted or \
              compared, and may be no unit at all.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [furlong/h] Sink rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] Sink rate\n",
    },
    measured: Some(Measured { findings: 1, sample: 1, right: 1, remark: "" }),
    check: Check::Reader(no_fix),
};
