//! `unknown-annotation`: an annotation that doesn't exist.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "unknown-annotation",
    statement: "An annotation that doesn't exist.",
    why: "The annotation is treated as text and has no effect. PX4's own tool stops with an error.",
    fix: "Use an existing annotation, or write plain text.",
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
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};
