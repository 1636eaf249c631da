//! `unknown-unit`: an unknown unit.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;

use super::rule::{Check, Levels, Measured, Rule, no_fix};

pub(super) const RULE: Rule = Rule {
    id: "unknown-unit",
    statement: "A unit that is not in uavspec's list.",
    why: "Values in this unit can't be converted or compared, and the text may not be a unit at all.",
    fix: "Use a unit from the list.",
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
    measured: Some(Measured { findings: 1, sample: 1, right: 1 }),
    check: Check::Reader(no_fix),
};
