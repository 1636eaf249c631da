//! `unknown-annotation`: an annotation that nobody knows.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "unknown-annotation",
    purpose: "Only the annotations of the language are read. Any other stays part of the text, and what it was \
              to say reaches no tool; PX4's own tool stops at it.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] [@limits 0, 10] Sink rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] [@range 0, 10] Sink rate\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
