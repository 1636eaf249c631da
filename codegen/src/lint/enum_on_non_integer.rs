//! `enum-on-non-integer`: an enum on a field that holds no integers.

use super::rule::{Check, Levels, Measured, Rule, no_fix};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "enum-on-non-integer",
    purpose: "A field that holds constants of an enum is of an integer type, and so are they. On any other \
              field the annotation does nothing.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               float32 gear  # [@enum GEAR] Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Reader(no_fix),
};
